"""Which pairs of bodies rejected configurations hit."""

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.goals.funnel import PairTally
from planning.domain.request.deadline import Deadline
from planning.goals.goal_query import GoalQuery
from planning.goals.start import overlap
from planning.world.collision.margins import PairMargins
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]


# So many are looked at however late it is: nothing would be said of any.
_AT_LEAST = 4


@dataclass
class CollisionTally:
    """Counts which pairs rejected configurations hit first.

    Attributes:
        depths: What was missing to the margin [m], by pair.
        num_only_near: Configurations in which nothing overlapped.
    """

    depths: dict[tuple[str, str], list[float]] = field(default_factory=lambda: defaultdict(list))
    num_only_near: int = 0

    def add(self, pairs: tuple[BodyPair, ...], margins: PairMargins) -> None:
        """Count a rejected configuration by the pair that lacks most of its margin, if any does."""
        if not pairs:
            return
        worst = max(pairs, key=lambda pair: margins.of(*pair.bodies) - pair.distance)
        self.depths[worst.bodies].append(margins.of(*worst.bodies) - worst.distance)
        self.num_only_near += not overlap(pairs)

    @property
    def summary(self) -> tuple[PairTally, ...]:
        """The tallies, most frequent pair first."""
        tallies = [PairTally(b, len(d), min(d), max(d)) for b, d in self.depths.items()]
        return tuple(sorted(tallies, key=lambda tally: (-tally.count, tally.bodies)))


def count_collisions(
    world: World, query: GoalQuery, rows: list[Array], deadline: Deadline
) -> CollisionTally:
    """Return which pairs some configurations of the group hit, as far as there is time to look.

    It is looked at the first few in any case.
    """
    tally = CollisionTally()
    for i, q in enumerate(rows):
        if i >= _AT_LEAST and deadline.is_over:
            break
        tally.add(world.violations(query.group, q, query.margins), query.margins)
    return tally
