"""ConstrainedOracle: collision checker that also checks path constraints."""

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.curves import motion_samples
from planning.domain.robot.manifold import Manifold
from planning.world.constraints.band_constraint import BandConstraint
from planning.world.constraints.compiled_constraint import CompiledConstraint
from planning.world.world import CollisionChecker

_MAX_CACHED = 100_000


class ConstrainedOracle:
    """Collision checker combined with path constraints; collisions, which are cheap, come first.

    Edges are sampled at each constraint's own step, if that is finer than the given resolution.
    """

    def __init__(
        self,
        inner: CollisionChecker,
        manifold: Manifold,
        constraints: tuple[CompiledConstraint, ...],
    ) -> None:
        """Combine a collision checker with compiled constraints."""
        self._inner, self._manifold, self._constraints = inner, manifold, constraints
        # A planner checks every state of its tree again when it extends it.
        self._known_free: set[bytes] = set()

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether the group at q, shape (nq,), is free and keeps the constraints."""
        key = q.tobytes()
        if key in self._known_free:
            return True
        is_free = self._inner.is_free(q) and all(
            bool(constraint.are_satisfied(q[None])[0]) for constraint in self._constraints
        )
        if is_free and len(self._known_free) < _MAX_CACHED:
            self._known_free.add(key)
        return is_free

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row."""
        free = self._inner.are_free(qs)
        for constraint in self._constraints:
            rows = np.flatnonzero(free)
            if not len(rows):
                break
            free[rows] = constraint.are_satisfied(qs[rows])
        return free

    def is_motion_free(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether every sample of a motion is free and keeps the constraints."""
        return self._inner.is_motion_free(
            origin, displacement, resolution
        ) and self._satisfies_constraints(origin, displacement, resolution)

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return the same for each pair of rows."""
        free = self._inner.are_motions_free(origins, displacements, resolution)
        for row in np.flatnonzero(free):
            free[row] = self._satisfies_constraints(origins[row], displacements[row], resolution)
        return free

    def _satisfies_constraints(self, origin: Array, displacement: Array, resolution: float) -> bool:
        return all(
            self._satisfies(constraint, origin, displacement, resolution)
            for constraint in self._constraints
        )

    def _satisfies(
        self, constraint: CompiledConstraint, origin: Array, displacement: Array, resolution: float
    ) -> bool:
        step = min(resolution, constraint.step)
        if isinstance(constraint, BandConstraint):
            return constraint.is_motion_satisfied(origin, displacement, step)
        motion = origin, displacement
        return motion_samples.is_motion_free(self._manifold, constraint.are_satisfied, motion, step)
