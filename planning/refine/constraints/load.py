"""Load: what a motion asks of a robot besides the rates of its joints, over what is allowed.

Torques, and how fast frames move. Along a curve r(s) with b = (ds/dt)^2 and u = d2s/dt2 the
motion has v = r' sqrt(b) and vdot = r'' b + r' u.
"""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Of what a joint can do, what holding still may take: nothing is timed that cannot be stopped.
MOST_HELD = 0.98
# Of a difference quotient, relative to 1 + |x|.
_STEP = 1e-6


@runtime_checkable
class Load(Protocol):
    """Vectors no longer than 1, some of each motion; of groups whose joints do not float.

    Attributes:
        parts: Into how many parts the intervals of the pace's grid are cut to look at it.
    """

    @property
    def parts(self) -> int:
        """How finely it is looked at: 1 for what changes little from one point to the next."""
        ...

    def vectors(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nq"],
        vdot: Float64[np.ndarray, "m nq"],
    ) -> Float64[np.ndarray, "m balls dims"]:
        """Return what a motion asks for over what is allowed."""
        ...

    def slopes(
        self,
        q: Float64[np.ndarray, "m nq"],
        v: Float64[np.ndarray, "m nq"],
        vdot: Float64[np.ndarray, "m nq"],
    ) -> Float64[np.ndarray, "3 m balls dims nq"]:
        """Return their derivatives with respect to q, v and vdot."""
        ...

    def pace_rows(
        self,
        q: Float64[np.ndarray, "m nq"],
        rate: Float64[np.ndarray, "m nq"],
        curvature: Float64[np.ndarray, "m nq"],
    ) -> tuple[Float64[np.ndarray, "m k"], Float64[np.ndarray, "m k"]]:
        """Return ahead and bend of inequalities ahead u + bend b <= 1 that keep the vectors so.

        Args:
            q: r(s).
            rate: r'.
            curvature: r''.
        """
        ...

    def held(self, q: Float64[np.ndarray, "m nq"]) -> Float64[np.ndarray, "m k"]:
        """Return what standing still asks for over what is allowed, if it asks for anything.

        What of this is beyond `MOST_HELD` no pace changes: it is not in the vectors.
        """
        ...

    def least_duration(self, ends: Float64[np.ndarray, "2 nq"]) -> float:
        """Return a time that no motion between two rests beats [s]; 0 is always one."""
        ...


def difference_quotients(
    function: Callable[..., Array], *at: Float64[np.ndarray, "m nq"]
) -> Float64[np.ndarray, "k m *out nq"]:
    """Return the derivatives of a function of m rows with respect to each of its k arguments.

    Args:
        function: Of arrays of shape (m, nq), row by row; returns shape (m, *out).
        at: Where.
    """
    m, nq = at[0].shape
    size = len(at)
    state = np.stack(at)
    moved = np.broadcast_to(state[:, None, None], (size, size, nq, m, nq)).copy()
    each, columns = np.arange(size)[:, None], np.arange(nq)
    moved[each, each, columns, :, columns] += (_STEP * (1 + np.abs(state))).transpose(0, 2, 1)
    # Of the steps only what floating point took of them counts.
    taken = moved[each, each, columns, :, columns] - state.transpose(0, 2, 1)
    now = function(*at)
    changes = function(*moved.reshape(size, -1, nq)).reshape(size, nq, *now.shape) - now
    wide = taken.reshape(*taken.shape, *[1] * (now.ndim - 1))
    return np.moveaxis(changes / wide, 1, -1)
