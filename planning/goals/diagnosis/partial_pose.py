"""PartialPoseSearch: nearest feasible pose that differs from a goal in one part only.

The part is the position or the rotation.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.geometry.pose import Pose
from planning.domain.request.deadline import Deadline
from planning.goals.ik.pose_attempts import PoseAttempts

# Poses per round, and rounds without improvement after which the search ends.
_POSES_PER_ROUND, _PATIENCE = 320, 3
# The same where Drake solves the IK one pose at a time.
_SLOW_POSES_PER_ROUND, _SLOW_PATIENCE = 8, 1
# Largest ratio of the new to the old error that counts as an improvement.
_IMPROVEMENT_RATIO = 0.998
# Growth factor of the search radius after each round without result.
_RADIUS_GROWTH = 3.0


class Freedom(Enum):
    """Part of the pose that may differ from the goal; its value is the search radius [m or rad]."""

    POSITION = 1.0
    ROTATION = np.pi


@dataclass(frozen=True)
class PartialPoseResult:
    """Feasible configuration whose tool pose differs from a goal in position or in rotation only.

    Attributes:
        error: Distance to the goal [m or rad].
        q: Configuration, shape (nq,).
        pose: Tool pose X_WT there.
    """

    error: float
    q: Float64[np.ndarray, " nq"]
    pose: Pose


class PartialPoseSearch:
    """Search by random poses: at growing distance until one is feasible, then nearer than it."""

    def __init__(self, attempts: PoseAttempts, goal: Pose, freedom: Freedom) -> None:
        """Prepare for a goal X_WG; the other part of the pose is kept to the solvers' accuracy."""
        self._attempts, self._goal, self._freedom = attempts, goal, freedom
        self._num_poses = _POSES_PER_ROUND if attempts.uses_kernel else _SLOW_POSES_PER_ROUND
        self._patience = _PATIENCE if attempts.uses_kernel else _SLOW_PATIENCE

    def run(
        self, initial_radius: float, rng: np.random.Generator, deadline: Deadline
    ) -> PartialPoseResult | None:
        """Return the nearest result found; None if there is none within the search radius.

        Args:
            initial_radius: First search radius [m or rad], a lower bound of the error.
            rng: Random generator of the attempts.
            deadline: Time limit, after which the best result so far is returned.
        """
        best, radius = None, max(initial_radius, 1e-4)
        while best is None and not deadline.is_over:
            best = self._best_of(radius * self._displacements(rng), None)
            if radius >= self._freedom.value:
                break
            radius = min(_RADIUS_GROWTH * radius, self._freedom.value)
        num_failed_rounds = 0
        while best is not None and num_failed_rounds < self._patience and not deadline.is_over:
            self._attempts.hints = best.q[None]
            nearer = self._best_of(best.error * self._displacements(rng), best.q)
            is_improved = nearer is not None and nearer.error < _IMPROVEMENT_RATIO * best.error
            num_failed_rounds = 0 if is_improved else num_failed_rounds + 1
            best = best if nearer is None else min(best, nearer, key=lambda one: one.error)
        return best

    def _best_of(self, displacements: Array, seed: Array | None) -> PartialPoseResult | None:
        rows = self._attempts.solve_displaced(self._goal, displacements, seed)
        results = [self._result_at(q) for q in rows]
        return min(results, key=lambda one: one.error, default=None)

    def _result_at(self, q: Array) -> PartialPoseResult:
        pose = self._attempts.pose_at(q)
        shift, turn = pose.distance(self._goal)
        return PartialPoseResult(shift if self._freedom is Freedom.POSITION else turn, q, pose)

    def _displacements(self, rng: np.random.Generator) -> Array:
        """Return displacements of length at most 1, a third of them along axes, shape (n, 6)."""
        third = _POSES_PER_ROUND // 3
        numbers = np.arange(third)
        axis_aligned = np.zeros((third, 3))
        axis_aligned[numbers, numbers % 6 // 2] = np.where(numbers % 2, 1, -1)
        axis_aligned *= 1 - ((numbers[:, None] // 6 + 0.5) / (third // 6 + 1)) ** 2
        general = rng.normal(size=(_POSES_PER_ROUND - third, 3))
        scales = rng.uniform(size=len(general)) ** (1 / 3) / np.linalg.norm(general, axis=1)
        general *= scales[:, None]
        displacements = np.zeros((_POSES_PER_ROUND, 6))
        columns = slice(0, 3) if self._freedom is Freedom.POSITION else slice(3, 6)
        displacements[:, columns] = rng.permutation(np.concatenate([axis_aligned, general]))
        return displacements[: self._num_poses]
