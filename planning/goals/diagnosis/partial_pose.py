"""The nearest free pose that is only shifted from a goal, or only turned."""

from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.pose import Pose
from planning.domain.request.deadline import Deadline
from planning.goals.ik.pose_attempts import PoseAttempts

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Poses that are tried at once, and how often in vain before the best is taken for the nearest.
_NUM_TRIES, _PATIENCE = 320, 3
# The same where Drake has to reach each of them by itself.
_NUM_SLOW, _PATIENCE_SLOW = 8, 1
# What is nearer by less than this share is no news.
_NEWS = 0.998
# While none is found, so many times farther it is looked next.
_FARTHER = 3.0


class Freedom(Enum):
    """What may differ from the goal, and how far it is looked at most [m or rad]."""

    POSITION = 1.0
    ROTATION = np.pi


@dataclass(frozen=True)
class PartialPoseResult:
    """A free configuration whose pose differs from a goal in one respect only.

    Attributes:
        error: By how much [m or rad].
        q: The configuration, shape (nq,).
        pose: X_WT there.
    """

    error: float
    q: Float64[np.ndarray, " nq"]
    pose: Pose


class PartialPoseSearch:
    """Poses farther and farther from a goal until one is free, then nearer and nearer ones."""

    def __init__(self, tries: PoseAttempts, goal: Pose, freedom: Freedom) -> None:
        """Look from a goal X_WG; the other respect is kept as exactly as solvers can."""
        self._tries, self._goal, self._freedom = tries, goal, freedom
        self._num_tries = _NUM_TRIES if tries.are_fast else _NUM_SLOW
        self._patience = _PATIENCE if tries.are_fast else _PATIENCE_SLOW

    def run(
        self, least: float, rng: np.random.Generator, deadline: Deadline
    ) -> PartialPoseResult | None:
        """Return the nearest that is found, None if there is none within reach of the search.

        Args:
            least: Where to begin [m or rad]; nothing nearer need be looked for.
            rng: Of the tries.
            deadline: When to stop with what there is.
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
        """Return displacements of length 1 at most: a third of them along the axes."""
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
