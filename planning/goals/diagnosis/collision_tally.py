"""CollisionTally: counts of the colliding body pairs over rejected configurations."""

from collections import defaultdict
from dataclasses import dataclass, field

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.goals.funnel import PairTally
from planning.domain.request.deadline import Deadline
from planning.goals.goal_query import GoalQuery
from planning.goals.start_validation import has_overlap
from planning.world.collision.margins import PairMargins
from planning.world.world import World

# Configurations measured even after the deadline, so that the tally is not empty.
_MIN_MEASURED = 4


@dataclass
class CollisionTally:
    """Tally of rejected configurations by their worst body pair.

    Attributes:
        depths: Margin minus distance [m] of each rejected configuration, by pair.
        num_margin_only: Number of configurations that violate margins without overlap.
    """

    depths: dict[tuple[str, str], list[float]] = field(default_factory=lambda: defaultdict(list))
    num_margin_only: int = 0

    def add(self, pairs: tuple[BodyPair, ...], margins: PairMargins) -> None:
        """Count a rejected configuration under its pair of largest margin violation, if any."""
        if not pairs:
            return
        worst = max(pairs, key=lambda pair: margins.of(*pair.bodies) - pair.distance)
        self.depths[worst.bodies].append(margins.of(*worst.bodies) - worst.distance)
        self.num_margin_only += not has_overlap(pairs)

    @property
    def summary(self) -> tuple[PairTally, ...]:
        """Count and depths of each pair, most frequent pair first."""
        tallies = [PairTally(b, len(d), min(d), max(d)) for b, d in self.depths.items()]
        return tuple(sorted(tallies, key=lambda tally: (-tally.count, tally.bodies)))


def count_collisions(
    world: World, query: GoalQuery, rows: list[Array], num_measured: int, deadline: Deadline
) -> CollisionTally:
    """Return the tally of colliding pairs of some configurations, until the deadline.

    They are spread evenly over all of them: those found one after another are often alike. The
    first `_MIN_MEASURED` of them are measured in any case.

    Args:
        world: Loaded scene.
        query: Goal query.
        rows: Colliding configurations, as they were found.
        num_measured: Most configurations that are measured.
        deadline: Time limit.
    """
    tally, count = CollisionTally(), min(num_measured, len(rows))
    probe = world.distance_probe(query.margins) if count else None
    for i, q in enumerate(rows[k * len(rows) // count] for k in range(count)):
        if probe is None or (i >= _MIN_MEASURED and deadline.is_over):
            break
        tally.add(probe.violations(world.embed(query.group, q)), query.margins)
    return tally
