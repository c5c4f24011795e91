"""CollisionOracle: what the search asks of a world, and what it adds to the answer."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.deadline import Deadline
from planning.domain.joints import JointGroup, JointLimits
from planning.domain.manifold import Manifold

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Flags = np.ndarray[Any, np.dtype[np.bool_]]


@runtime_checkable
class CollisionOracle(Protocol):
    """Says whether configurations of a group are admissible."""

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether the group at q, shape (nq,), keeps its distances."""
        ...

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row of qs, shape (m, nq)."""
        ...


class WatchedOracle:
    """An oracle that counts, keeps limits on circles, and ends the search when time is up.

    The bounds of OMPL's spaces hold every other coordinate; on a circle OMPL knows none.

    Attributes:
        num_states: Configurations asked for so far.
    """

    def __init__(
        self, inner: CollisionOracle, group: JointGroup, limits: JointLimits, deadline: Deadline
    ) -> None:
        """Watch `inner`, for the joints and limits of a group."""
        self._inner = inner
        self._deadline = deadline
        self._circle, self._lower, self._width = _bounded_circles(group, limits)
        self.num_states = 0

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether q, shape (nq,), is admissible.

        Raises:
            Canceled: Somebody asked for the end.
            DeadlineExceeded: The time has run out.
        """
        self._deadline.check("search")
        self.num_states += 1
        if self._circle and not self._keeps_circles(q[None])[0]:
            return False
        return self._inner.is_free(q)

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row of qs, shape (m, nq).

        Raises:
            Canceled: Somebody asked for the end.
            DeadlineExceeded: The time has run out.
        """
        self._deadline.check("search")
        self.num_states += len(qs)
        verdicts = self._inner.are_free(qs)
        return verdicts & self._keeps_circles(qs) if self._circle else verdicts

    def _keeps_circles(self, qs: Array) -> Flags:
        beyond = np.remainder(qs[:, self._circle] - self._lower, 2 * np.pi)
        dust = 1e-9
        return ((beyond <= self._width + dust) | (beyond >= 2 * np.pi - dust)).all(axis=1)


def _bounded_circles(group: JointGroup, limits: JointLimits) -> tuple[list[int], Array, Array]:
    """Return the coordinates of q that are angles on a circle with an arc forbidden."""
    width = limits.upper - limits.lower
    found: list[int] = []
    iq = 0
    for joint in group.joints:
        wraps = Manifold((joint,)).wraps
        count = len(joint.position_names)
        if any(wraps):
            found += [iq + k for k in range(count) if wraps[k] and width[iq + k] < 2 * np.pi]
        iq += count
    return found, limits.lower[found], width[found]
