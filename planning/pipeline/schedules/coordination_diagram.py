"""Coordination diagram of two motions: the relative delays at which their robots come too near.

The state of two motions is a point (t_1, t_2) of their own times. Begun with the relative delay
r = begin_2 - begin_1, they pass through the points with t_1 - t_2 = r, so r is blocked if one of
these is an encounter: a pair of bodies, one moved by each, nearer than its margin. Before it begins
and after it has ended a motion rests, so the diagram has a strip without end at each side.
(O'Donnell & Lozano-Perez, "Deadlock-free and collision-free coordination of two robot
manipulators", 1989; Simeon, Leroy & Laumond, "Path coordination for multiple mobile robots", 2002.)

Rectangles of the diagram are halved until each is decided. With all points of both robots'
bodies displaced by no more than D from the rectangle's centre, it is free if the centre keeps the
margin with D to spare, and an encounter all over if the centre misses the margin by more than D.
What is too small to be halved and still undecided counts as an encounter, so the free delays are
on the safe side; that a schedule is proven, the certificate says.
"""

from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array, Flags
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.pipeline.schedules.blocked_delays import BlockedDelays, Encounter
from planning.pipeline.schedules.motion_spans import MotionSpans, Span
from planning.pipeline.schedules.shared_bodies import SharedPairs
from planning.world.world import CollisionChecker, World

# Rectangles in which bodies move more than this are halved without a look [m].
_MAX_DISPLACEMENT = 0.3
# Displacements are rounded up to powers of this, so that few collision checkers are made.
_RATIO = 1.5
_ROUNDING = 1e-6

type Cell = tuple[Span, Span]


@dataclass(frozen=True)
class PairOfMotions:
    """Two of the motions, by their indices, with the group that spans both.

    Attributes:
        first: Index of the first.
        second: Index of the second.
        group: Group that spans the two, in this order.
        spans: Of each.
    """

    first: int
    second: int
    group: JointGroup
    spans: tuple[MotionSpans, MotionSpans]


def blocked_delays(
    world: World, pair: PairOfMotions, shared: SharedPairs, deadline: Deadline
) -> BlockedDelays:
    """Return the relative delays begin_2 - begin_1 of two motions that may not be kept.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    blocked = BlockedDelays()
    check = _Check(world, pair, shared)
    first, second = pair.spans
    cells: list[Cell] = [(a, b) for a in first.roots for b in second.roots]
    while cells:
        deadline.check("schedule")
        blocked.merge()
        low, high = _delays(cells)
        is_pending = ~blocked.are_covered(low, high)
        cells = [cell for cell, flag in zip(cells, is_pending, strict=True) if flag]
        children: list[Cell] = []
        for cell, is_free, is_encounter in zip(cells, *check.outcomes(cells), strict=True):
            if is_free:
                continue
            if not is_encounter and (cell[0].is_divisible or cell[1].is_divisible):
                children += _divided(pair, cell)
                continue
            a, b = cell
            blocked.add(
                a.begin - b.end, a.end - b.begin, Encounter(a.center, b.center, (a.time, b.time))
            )
        cells = children
    blocked.merge()
    return blocked


def _delays(cells: list[Cell]) -> tuple[Array, Array]:
    """Return the smallest and the largest relative delay through each rectangle."""
    low = np.array([a.begin - b.end for a, b in cells], dtype=np.float64)
    high = np.array([a.end - b.begin for a, b in cells], dtype=np.float64)
    return low, high


def _divided(pair: PairOfMotions, cell: Cell) -> list[Cell]:
    """Return both halves of a rectangle, across the motion that displaces bodies more."""
    a, b = cell
    of_first = a.is_divisible and (a.displacement >= b.displacement or not b.is_divisible)
    if of_first:
        return [(half, b) for half in pair.spans[0].halves(a)]
    return [(a, half) for half in pair.spans[1].halves(b)]


class _Check:
    """Collision checks of rectangles' centres, with margins that grow or shrink by a padding."""

    def __init__(self, world: World, pair: PairOfMotions, shared: SharedPairs) -> None:
        self._world, self._pair, self._shared = world, pair, shared
        self._oracles: dict[float, CollisionChecker] = {}

    def outcomes(self, cells: list[Cell]) -> tuple[Flags, Flags]:
        """Return which rectangles are free, and which are encounters all over."""
        count = len(cells)
        is_free, is_encounter = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        displacement = np.array([a.displacement + b.displacement for a, b in cells])
        level = np.ceil(np.log(np.maximum(displacement, _ROUNDING)) / np.log(_RATIO))
        rows = np.array([np.concatenate([a.center, b.center]) for a, b in cells])
        for k in np.unique(level):
            chosen = np.flatnonzero((level == k) & (displacement <= _MAX_DISPLACEMENT))
            if not len(chosen):
                continue
            padding = float(_RATIO**k) + _ROUNDING
            is_free[chosen] = self._keep(rows[chosen], padding)
            others = chosen[~is_free[chosen]]
            if len(others):
                is_encounter[others] = ~self._keep(rows[others], -padding)
        return is_free, is_encounter

    def _keep(self, rows: Array, padding: float) -> Flags:
        """Return which configurations keep the margins of the pairs of both, padded [m]."""
        if padding not in self._oracles:
            margins = self._shared.margins_of(self._pair.first, self._pair.second, padding)
            self._oracles[padding] = self._world.collision_oracle(self._pair.group, margins)
        return np.asarray(self._oracles[padding].are_free(np.ascontiguousarray(rows)))
