"""ProjectedSpace: a search space whose samples are brought onto a thin set by projection.

OMPL's constrained state spaces (Kingston, Moll, Kavraki, "Exploring implicit spaces for constrained
sampling-based planning", IJRR 38:10, 2019): a sample is projected by Newton's method onto the zero
set of a residual, and a motion is a chain of short steps, each projected. Here the residual
vanishes on a set with an inside (a cone, a box) and measures how far outside a state is, so what is
inside moves freely. It is R^n only: joints that neither wrap nor float.
"""

from typing import Any, Protocol, override, runtime_checkable

import numpy as np
from jaxtyping import Float64
from ompl import base as ob
from ompl import geometric as og

from planning.domain.robot.joints import JointGroup, JointLimits
from planning.search.collision_oracle import WatchedOracle
from planning.search.ompl.spaces import SearchSpace

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Length of a step along the set [rad or m], and how near to it is on it.
STEP = 0.1
ON = 1e-5
MOST_ITERATIONS = 20


@runtime_checkable
class Residual(Protocol):
    """By how much a configuration misses a set; zero on it."""

    @property
    def size(self) -> int:
        """How many numbers it has."""
        ...

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, " size"]:
        """Return it at q, shape (nq,)."""
        ...

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "size nv"]:
        """Return its derivative; zero in rows that vanish."""
        ...


class ProjectedSpace(SearchSpace):
    """A space of a group of bounded joints, within which a residual vanishes.

    Attributes:
        residual: What vanishes.
    """

    def __init__(
        self,
        group: JointGroup,
        limits: JointLimits,
        anchors: Float64[np.ndarray, "m nq"],
        residual: Residual,
    ) -> None:
        """Build the space.

        Args:
            group: The joints, none of which wraps or floats.
            limits: Their position limits.
            anchors: Configurations that must lie inside, shape (m, nq).
            residual: What shall vanish.
        """
        super().__init__(group, limits, anchors)
        self.residual = residual
        self._count = group.num_positions
        # OMPL keeps no reference of its own to what Python made.
        self._constraint = _Residual(residual, self._count)
        self._ambient = self.ompl
        self.ompl: Any = ob.ProjectedStateSpace(self._ambient, self._constraint)
        self.numbers = self._coordinates

    @override
    def write(self, q: Float64[np.ndarray, " nq"]) -> Any:
        """Return a new OMPL state at q, shape (nq,)."""
        state = self.ompl.allocState()
        state.copy(np.clip(q, self.lower, self.upper).tolist())
        return state

    def information(self, oracle: WatchedOracle) -> Any:
        """Return OMPL's space information, ready to plan with."""
        read, is_free = self.read, oracle.is_free
        information = ob.ConstrainedSpaceInformation(self.ompl)
        self.ompl.setDelta(STEP)
        information.setStateValidityChecker(lambda state: is_free(read(state)))
        information.setup()
        return information

    def threaded(self, information: Any, waypoints: Float64[np.ndarray, "n nq"]) -> Array:
        """Return every step of the motions between waypoints, which are no straight lines."""
        path = og.PathGeometric(information)
        for q in waypoints:
            path.append(self.write(q))
        path.interpolate()
        return np.array([self.read(state) for state in path.getStates()])

    def _coordinates(self, state: Any) -> list[float]:
        return [state[i] for i in range(self._count)]


class _Residual(ob.Constraint):
    """A residual as OMPL asks for it."""

    def __init__(self, residual: Residual, count: int) -> None:
        # OMPL demands fewer equations than dimensions; ours mostly vanish, so a sum may do.
        self._is_stacked = residual.size < count
        super().__init__(count, residual.size if self._is_stacked else 1, ON)
        self.setMaxIterations(MOST_ITERATIONS)
        self._residual = residual

    def function(self, state: Any, out: Any) -> None:
        """Write the residual at a state, of which OMPL gives the numbers."""
        found = self._residual.residual(np.array(state))
        out[:] = found if self._is_stacked else np.linalg.norm(found)

    @override
    def jacobian(self, x: Any, out: Any) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]  (its overloads disagree on the name)
        """Write its derivative there."""
        q = np.array(x)
        slopes = self._residual.jacobian(q)
        if self._is_stacked:
            out[:, :] = slopes
            return
        found = self._residual.residual(q)
        length = max(float(np.linalg.norm(found)), 1e-300)
        out[0, :] = (found / length) @ slopes
