"""Functions with gradients by hand, as evaluators of Drake's programs."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff

from planning.domain.arrays import Array


def constraint_evaluator(function: Callable[[Array], tuple[Array, Array]]) -> Callable[[Any], Any]:
    """Return an evaluator for numbers and for AutoDiffXd.

    Args:
        function: Takes x, shape (n,); returns values, shape (m,), and their gradients, (m, n).
    """

    def evaluate(x: Any) -> Any:
        if x.dtype != object:
            return function(x)[0]
        values, gradients = function(ExtractValue(x).ravel())
        return InitializeAutoDiff(values, gradients @ ExtractGradient(x)).ravel()

    return evaluate


def cost_evaluator(function: Callable[[Array], tuple[float, Array]]) -> Callable[[Any], Any]:
    """Return an evaluator of a scalar function, which returns its value and gradient (n,)."""

    def evaluate(x: Any) -> Any:
        if x.dtype != object:
            return function(x)[0]
        value, gradient = function(ExtractValue(x).ravel())
        return InitializeAutoDiff(np.array([value]), gradient[None] @ ExtractGradient(x)).ravel()[0]

    return evaluate
