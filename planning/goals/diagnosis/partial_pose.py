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
_NUM_TRIES, _PATIENCE = 320, 3
# The same where Drake solves the IK one pose at a time.
_NUM_SLOW, _PATIENCE_SLOW = 8, 1
# Largest ratio of the new to the old error that counts as an improvement.
_NEWS = 0.998
# Growth factor of the search radius after each round without result.
_FARTHER = 3.0


class Freedom(Enum):
    """Part of the pose that may differ from the goal; its value is the search radius [m or rad]."""

    POSITION = 1.0
    ROTATION = np.pi


@dataclass(frozen=True)
class PartialPoseResult:
    """Feasible configuration whose pose differs from a goal in position or in rotation only.

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

    def __init__(self, tries: PoseAttempts, goal: Pose, freedom: Freedom) -> None:
        """Prepare for a goal X_WG; the other part of the pose is kept to the solvers' accuracy."""
        self._tries, self._goal, self._freedom = tries, goal, freedom
        self._num_tries = _NUM_TRIES if tries.are_fast else _NUM_SLOW
        self._patience = _PATIENCE if tries.are_fast else _PATIENCE_SLOW

    def run(
        self, least: float, rng: np.random.Generator, deadline: Deadline
    ) -> PartialPoseResult | None:
        """Return the nearest result found; None if there is none within the search radius.

        Args:
            least: First search radius [m or rad], a lower bound of the error.
            rng: Random generator of the attempts.
            deadline: Time limit, after which the best result so far is returned.
        """
        best, reach = None, max(least, 1e-4)
        while best is None and not deadline.is_over:
            best = self._best_of(reach * self._moves(rng), None)
            if reach >= self._freedom.value:
                break
            reach = min(_FARTHER * reach, self._freedom.value)
        missed = 0
        while best is not None and missed < self._patience and not deadline.is_over:
            self._tries.hints = best.q[None]
            nearer = self._best_of(best.error * self._moves(rng), best.q)
            is_news = nearer is not None and nearer.error < _NEWS * best.error
            missed = 0 if is_news else missed + 1
            best = best if nearer is None else min(best, nearer, key=lambda one: one.error)
        return best

    def _best_of(self, moves: Array, near: Array | None) -> PartialPoseResult | None:
        rows = self._tries.reach(self._goal, moves, near)
        found = [self._judged(q) for q in rows]
        return min(found, key=lambda one: one.error, default=None)

    def _judged(self, q: Array) -> PartialPoseResult:
        reached = self._tries.pose_at(q)
        shift, turn = reached.distance(self._goal)
        return PartialPoseResult(shift if self._freedom is Freedom.POSITION else turn, q, reached)

    def _moves(self, rng: np.random.Generator) -> Array:
        """Return displacements of length at most 1, a third of them along axes, shape (n, 6)."""
        third = _NUM_TRIES // 3
        numbers = np.arange(third)
        along = np.zeros((third, 3))
        along[numbers, numbers % 6 // 2] = np.where(numbers % 2, 1, -1)
        along *= 1 - ((numbers[:, None] // 6 + 0.5) / (third // 6 + 1)) ** 2
        aside = rng.normal(size=(_NUM_TRIES - third, 3))
        aside *= (rng.uniform(size=len(aside)) ** (1 / 3) / np.linalg.norm(aside, axis=1))[:, None]
        moves = np.zeros((_NUM_TRIES, 6))
        moved = slice(0, 3) if self._freedom is Freedom.POSITION else slice(3, 6)
        moves[:, moved] = rng.permutation(np.concatenate([along, aside]))
        return moves[: self._num_tries]
