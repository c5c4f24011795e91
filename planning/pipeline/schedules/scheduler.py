"""Scheduler: delays of several motions, by the diagrams of all pairs, and who waits for whom."""

from collections.abc import Sequence
from itertools import combinations

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.motion_schedule import Wait
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.spanning_group import joined_name
from planning.pipeline.schedules.blocked_delays import Encounter
from planning.pipeline.schedules.coordination_diagram import PairOfMotions, blocked_delays
from planning.pipeline.schedules.delay_network import Delays, smallest_delays
from planning.pipeline.schedules.encounters import always_meet, circular, nearest_pair
from planning.pipeline.schedules.motion_spans import MIN_SPAN, MotionSpans
from planning.pipeline.schedules.shared_bodies import SharedPairs
from planning.world.collision.margins import PairMargins
from planning.world.world import World


class Scheduler:
    """Schedules of some motions, without proof.

    Attributes:
        names: Names of the motions' groups.
    """

    def __init__(
        self,
        world: World,
        groups: Sequence[JointGroup],
        trajectories: Sequence[TimedTrajectory],
        margins: PairMargins,
        deadline: Deadline,
    ) -> None:
        """Find the relative delays at which each two of the motions may meet.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
            ModelInvalid: A shape or a joint of a kind that cannot be certified.
        """
        self._world, self._margins, self._deadline = world, margins, deadline
        self._trajectories = trajectories
        self.names = tuple(group.name for group in groups)
        self._shared = SharedPairs(world.drake, groups, margins)
        spans = [
            MotionSpans(world, group, trajectory)
            for group, trajectory in zip(groups, trajectories, strict=True)
        ]
        self._pairs = {
            (i, j): PairOfMotions(
                i,
                j,
                world.group(joined_name([groups[i].name, groups[j].name])),
                (spans[i], spans[j]),
            )
            for i, j in combinations(range(len(groups)), 2)
        }
        self._blocked = {
            key: blocked_delays(world, pair, self._shared, deadline)
            for key, pair in self._pairs.items()
        }

    def smallest(self) -> Delays:
        """Return the lexicographically smallest delays that no diagram blocks.

        Raises:
            ScheduleNotFound: There are none.
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        allowed = {key: blocked.free for key, blocked in self._blocked.items()}
        for key, intervals in allowed.items():
            if not intervals:
                raise always_meet(
                    self._world,
                    self._pairs[key],
                    (self.names, self._shared, self._margins),
                    self._blocked[key],
                )
        found = smallest_delays(len(self.names), allowed, self._deadline)
        if found is None:
            terms = self.names, self._shared, self._margins
            raise circular(self._world, self._pairs, terms, self._blocked)
        return found

    def block(self, delays: Delays, bodies: tuple[str, str]) -> bool:
        """Block the relative delay of the two motions that some bodies depend on.

        Returns:
            Whether there are two such motions; if not, no delay can keep the bodies apart.
        """
        movers = sorted(self._shared.motions_of(bodies))
        if len(movers) < 2:
            return False
        i, j = movers[:2]
        delay = delays.delays[j] - delays.delays[i]
        ends = self._trajectories[i].end, self._trajectories[j].end
        encounter = Encounter(*ends, (0.0, 0.0))
        self._blocked[i, j].add(delay - MIN_SPAN, delay + MIN_SPAN, encounter)
        self._blocked[i, j].merge()
        return True

    def waits(self, delays: Delays) -> tuple[Wait, ...]:
        """Return each motion that waits, and for which one."""
        return tuple(
            self._wait(k, other, delays.delays)
            for k, other in enumerate(delays.waits_for)
            if other is not None and delays.delays[k] > 0
        )

    def _wait(self, waiting: int, other: int, delays: Sequence[float]) -> Wait:
        i, j = min(waiting, other), max(waiting, other)
        encounter = self._blocked[i, j].encounter_at(delays[j] - delays[i])
        near = nearest_pair(
            self._world, self._pairs[i, j], (self._shared, self._margins), encounter
        )
        time = encounter.times[1] if other == j else encounter.times[0]
        return Wait(
            self.names[waiting],
            self.names[other],
            delays[waiting],
            near.bodies,
            delays[other] + time,
        )
