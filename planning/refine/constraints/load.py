"""Load: a quantity of a motion over its limit, besides joint rates: torques, and speeds of frames.

Along a curve r(s) with b = (ds/dt)^2 and u = d2s/dt2 the motion has v = r' sqrt(b) and vdot = r'' b
+ r' u.
"""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array

# Largest static load ratio: above it too little of a limit is left to stop a motion.
MOST_HELD = 0.98
# Step of a difference quotient, relative to 1 + |x|.
_STEP = 1e-6


@runtime_checkable
class Load(Protocol):
    """Vectors of load ratios (quantity over limit) whose norms must not exceed 1.

    Only for groups whose joints do not float.

    Attributes:
        parts: Number of parts per interval of the path velocity's grid at whose ends it is
            evaluated.
    """

    @property
    def parts(self) -> int:
        """Parts per grid interval: 1 for loads that change little between grid points."""
        ...

    def vectors(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nq"],
        vdot: Float64[np.ndarray, "m nq"],
    ) -> Float64[np.ndarray, "m balls dims"]:
        """Return the load ratios of a motion."""
        ...

    def slopes(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nq"],
        vdot: Float64[np.ndarray, "m nq"],
    ) -> Float64[np.ndarray, "3 m balls dims nq"]:
        """Return the derivatives of the ratios with respect to q, v and vdot."""
        ...

    def pace_rows(
        self,
        q: Float64[np.ndarray, "m nq"],
        rate: Float64[np.ndarray, "m nq"],
        curvature: Float64[np.ndarray, "m nq"],
    ) -> tuple[Float64[np.ndarray, "m k"], Float64[np.ndarray, "m k"]]:
        """Return coefficients ahead, bend of rows ahead u + bend b <= 1 that imply the limits.

        Args:
            q: r(s).
            rate: r'.
            curvature: r''.
        """
        ...

    def held(self, q: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, "m k"]:
        """Return the static load ratios, at rest; no columns if the load has none.

        Their part beyond `MOST_HELD` does not depend on the path velocity: it is not in `vectors`.
        """
        ...

    def least_duration(self, ends: Float64[np.ndarray, "2 nq"]) -> float:
        """Return a lower bound of the duration from rest to rest [s]; 0 is always valid."""
        ...


def difference_quotients(
    function: Callable[..., Array], *at: Float64[np.ndarray, "m nq"]
) -> Float64[np.ndarray, "k m *out nq"]:
    """Return the derivatives of a function of m rows with respect to each of its k arguments.

    Args:
        function: Of arrays of shape (m, nq), row by row; returns shape (m, *out).
        at: Arguments at which the derivatives are taken.
    """
    m, nq = at[0].shape
    size = len(at)
    state = np.stack(at)
    moved = np.broadcast_to(state[:, None, None], (size, size, nq, m, nq)).copy()
    each, columns = np.arange(size)[:, None], np.arange(nq)
    moved[each, each, columns, :, columns] += (_STEP * (1 + np.abs(state))).transpose(0, 2, 1)
    # The effective steps after rounding.
    taken = moved[each, each, columns, :, columns] - state.transpose(0, 2, 1)
    now = function(*at)
    changes = function(*moved.reshape(size, -1, nq)).reshape(size, nq, *now.shape) - now
    wide = taken.reshape(*taken.shape, *[1] * (now.ndim - 1))
    return np.moveaxis(changes / wide, 1, -1)
