"""Arrays and numbers of the domain as fields of models."""

import math
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator

from planning.domain.arrays import Array


def vector(numbers: Sequence[float]) -> Array:
    """Return numbers of a request as an array."""
    return np.array(numbers, dtype=np.float64)


def matrix(rows: Sequence[Sequence[float]]) -> Array:
    """Return rows of numbers of a request as an array."""
    return np.array(rows, dtype=np.float64)


def _as_lists(numbers: Any) -> Any:
    is_array = isinstance(numbers, np.ndarray)
    return numbers.astype(np.float64, copy=False).tolist() if is_array else numbers


def _finite_or_none(number: Any) -> Any:
    return None if isinstance(number, float) and not math.isfinite(number) else number


# Of answers, made from values of the domain: arrays, and numbers that JSON cannot hold (null).
Row = Annotated[list[float], BeforeValidator(_as_lists)]
Rows = Annotated[list[list[float]], BeforeValidator(_as_lists)]
FiniteOrNull = Annotated[float | None, BeforeValidator(_finite_or_none)]
