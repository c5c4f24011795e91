"""Load: a quantity of a motion over its limit, besides joint rates: torques, and speeds of frames.

Along a curve r(s) with b = (ds/dt)^2 and u = d2s/dt2 the motion has v = r' sqrt(b) and vdot = r'' b
+ r' u.
"""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.constraints.path_load import PathLoad

# Largest static load ratio: above it too little of a limit is left to stop a motion.
MAX_STATIC_LOAD = 0.98
# Step of a difference quotient, relative to 1 + |x|.
DIFFERENCE_STEP = 1e-6


@runtime_checkable
class Load(Protocol):
    """Vectors of load ratios (quantity over limit) whose norms must not exceed 1.

    Only for groups whose joints do not float.

    Attributes:
        num_parts: Number of parts per interval of the path velocity's grid at whose ends it is
            evaluated.
    """

    @property
    def num_parts(self) -> int:
        """Parts per grid interval: 1 for loads that change little between grid points."""
        ...

    def load_ratios(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nq"],
        vdot: Float64[np.ndarray, "m nq"],
    ) -> Float64[np.ndarray, "m balls dims"]:
        """Return the load ratios of a motion."""
        ...

    def derivatives(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nq"],
        vdot: Float64[np.ndarray, "m nq"],
    ) -> Float64[np.ndarray, "3 m balls dims nq"]:
        """Return the derivatives of the ratios with respect to q, v and vdot."""
        ...

    def along(
        self,
        q: Float64[np.ndarray, "m nq"],
        rate: Float64[np.ndarray, "m nq"],
        curvature: Float64[np.ndarray, "m nq"],
    ) -> PathLoad:
        """Return the load of all motions along a curve.

        Args:
            q: r(s).
            rate: r'.
            curvature: r''.
        """
        ...

    def static_load(self, q: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, "m k"]:
        """Return the static load ratios, at rest; no columns if the load has none.

        Their part beyond `MAX_STATIC_LOAD` does not depend on the path velocity: it is not in
        `load_ratios`.
        """
        ...

    def duration_lower_bound(self, ends: Float64[np.ndarray, "2 nq"]) -> float:
        """Return a lower bound of the duration from rest to rest [s]; 0 is always valid."""
        ...


def difference_quotients(
    function: Callable[..., Array], *at: Float64[np.ndarray, "m nq"]
) -> Float64[np.ndarray, "k m *out nq"]:
    """Return the derivatives of a function of m rows with respect to each of its k arguments.

    Args:
        function: Function of arrays of shape (m, nq), row by row; returns shape (m, *out).
        at: Arguments at which the derivatives are taken.
    """
    m, nq = at[0].shape
    num_arguments = len(at)
    state = np.stack(at)
    shifted = np.broadcast_to(
        state[:, None, None], (num_arguments, num_arguments, nq, m, nq)
    ).copy()
    arguments, columns = np.arange(num_arguments)[:, None], np.arange(nq)
    shifted[arguments, arguments, columns, :, columns] += (
        DIFFERENCE_STEP * (1 + np.abs(state))
    ).transpose(0, 2, 1)
    # The effective steps after rounding.
    steps = shifted[arguments, arguments, columns, :, columns] - state.transpose(0, 2, 1)
    values = function(*at)
    changes = (
        function(*shifted.reshape(num_arguments, -1, nq)).reshape(num_arguments, nq, *values.shape)
        - values
    )
    divisors = steps.reshape(*steps.shape, *[1] * (values.ndim - 1))
    return np.moveaxis(changes / divisors, 1, -1)
