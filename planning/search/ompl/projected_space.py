"""ProjectedSpace: a constrained state space whose samples are projected onto a thin set.

OMPL's constrained state spaces (Kingston, Moll, Kavraki, "Exploring implicit spaces for constrained
sampling-based planning", IJRR 38:10, 2019): a sample is projected by Newton's method onto the zero
set of a residual, and a motion is a chain of short steps, each projected. Here the residual
vanishes on a set with an interior (a cone, a box) and measures how far outside a state is, so
states in the interior move freely. Only for R^n: joints that neither wrap nor float.
"""

from collections.abc import Callable
from typing import Any, Protocol, override, runtime_checkable

import numpy as np
from jaxtyping import Float64
from ompl import base as ob
from ompl import geometric as og

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.search.collision_oracle import WatchedOracle
from planning.search.ompl.spaces import SearchSpace

# Length of a step along the set, and residual norm at which a state is on it [rad or m].
SET_STEP = 0.1
SET_TOLERANCE = 1e-5
MAX_ITERATIONS = 20


@runtime_checkable
class Residual(Protocol):
    """Violation of a constraint by a configuration; zero where the constraint holds."""

    @property
    def size(self) -> int:
        """Number of components."""
        ...

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, " size"]:
        """Return the residual at q, shape (nq,)."""
        ...

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "size nv"]:
        """Return its derivative with respect to v; zero in rows whose residual is zero."""
        ...


class ProjectedSpace(SearchSpace):
    """Constrained state space of a group of bounded joints: the zero set of a residual.

    Attributes:
        residual: Constraint residual.
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
            residual: Constraint residual.
        """
        super().__init__(group, limits, anchors)
        self.residual = residual
        self._num_positions = group.num_positions
        # OMPL keeps no reference of its own to Python objects.
        self._constraint = _OmplConstraint(residual, self._num_positions)

    @override
    def _make_ompl(self) -> Any:
        self._ambient = super()._make_ompl()
        return ob.ProjectedStateSpace(self._ambient, self._constraint)

    @override
    def write(self, q: Float64[np.ndarray, " nq"]) -> Any:
        """Return a new OMPL state at q, shape (nq,)."""
        state = self.ompl.allocState()
        state.copy(np.clip(q, self.lower, self.upper).tolist())
        return state

    def information(self, oracle: WatchedOracle) -> Any:
        """Return OMPL's space information after its setup."""
        read, is_free = self.read, oracle.is_free
        information = ob.ConstrainedSpaceInformation(self.ompl)
        self.ompl.setDelta(SET_STEP)
        information.setStateValidityChecker(lambda state: is_free(read(state)))
        information.setup()
        return information

    def interpolate(self, information: Any, waypoints: Float64[np.ndarray, "n nq"]) -> Array:
        """Return all states of the projected motions between waypoints, shape (m, nq)."""
        path = og.PathGeometric(information)
        for q in waypoints:
            path.append(self.write(q))
        path.interpolate()
        return np.array([self.read(state) for state in path.getStates()])

    @override
    def _make_reader(self) -> Callable[[Any], list[float]]:
        count = self._num_positions
        return lambda state: [state[i] for i in range(count)]


class _OmplConstraint(ob.Constraint):
    """Residual as an OMPL constraint."""

    def __init__(self, residual: Residual, count: int) -> None:
        # OMPL requires fewer equations than dimensions; otherwise the norm of the residual replaces
        # it.
        self._is_stacked = residual.size < count
        super().__init__(count, residual.size if self._is_stacked else 1, SET_TOLERANCE)
        self.setMaxIterations(MAX_ITERATIONS)
        self._residual = residual

    def function(self, state: Any, out: Any) -> None:
        """Write the residual at a state, given as its numbers."""
        residual = self._residual.residual(np.array(state))
        out[:] = residual if self._is_stacked else np.linalg.norm(residual)

    @override
    def jacobian(self, x: Any, out: Any) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]  (its overloads disagree on the name)
        """Write the residual's derivative at a state."""
        q = np.array(x)
        jacobian = self._residual.jacobian(q)
        if self._is_stacked:
            out[:, :] = jacobian
            return
        residual = self._residual.residual(q)
        length = max(float(np.linalg.norm(residual)), 1e-300)
        out[0, :] = (residual / length) @ jacobian
