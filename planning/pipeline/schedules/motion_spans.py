"""MotionSpans: spans of time of one motion, each with a configuration and a bound on the motion.

Before it begins and after it has ended a motion rests; those are spans too, without an end.
"""

from dataclasses import dataclass

import numpy as np

from planning.certify.clearance.candidate_pairs import geometry_of
from planning.certify.clearance.motion_bounds import MotionBounds
from planning.certify.clearance.placed_shapes import PlacedShapes
from planning.certify.intervals.joint_deviation import Segment, Segments
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup
from planning.world.contexts import shared_context
from planning.world.world import World

# Spans are not halved below this [s].
MIN_SPAN = 0.002


@dataclass(frozen=True)
class Span:
    """Span of time of a motion.

    Attributes:
        begin: First instant, by the motion's own time; minus infinity of the rest before it [s].
        end: Last instant; infinity of the rest after it [s].
        time: Instant of `center` [s].
        center: Configuration q of the group then.
        displacement: Largest displacement of a point of the group's bodies from there [m].
        segment: The same for the certifier; None at rest.
    """

    begin: float
    end: float
    time: float
    center: Array
    displacement: float
    segment: Segment | None

    @property
    def is_divisible(self) -> bool:
        """Whether it may be halved."""
        return self.segment is not None and self.end - self.begin > MIN_SPAN


class MotionSpans:
    """Spans of one motion, from the whole to halves of halves, each computed once."""

    def __init__(self, world: World, group: JointGroup, trajectory: TimedTrajectory) -> None:
        """Prepare to bound the displacement of the group's shapes.

        Raises:
            ModelInvalid: A shape or a joint of a kind that cannot be certified.
        """
        self._world, self._group = world, group
        shapes = geometry_of(world.drake).shapes
        self._bounds = MotionBounds(world.drake, group, shapes)
        self._placed = PlacedShapes(world.drake, shapes, self._bounds)
        plant = world.drake.plant
        self._context = plant.GetMyMutableContextFromRoot(shared_context(world.drake))
        self._segments = Segments(trajectory)
        self._halves: dict[tuple[float, float], tuple[Span, Span]] = {}
        duration = trajectory.duration
        self.roots = (
            Span(-np.inf, 0.0, 0.0, trajectory.start, 0.0, None),
            self._span(self._segments.whole),
            Span(duration, np.inf, duration, trajectory.end, 0.0, None),
        )

    def halves(self, span: Span) -> tuple[Span, Span]:
        """Return two spans that cover a divisible one."""
        key = span.begin, span.end
        if key not in self._halves:
            assert span.segment is not None  # noqa: S101  (it is divisible)
            first, second = self._segments.halves(span.segment)
            self._halves[key] = self._span(first), self._span(second)
        return self._halves[key]

    def _span(self, segment: Segment) -> Span:
        displacement = self._displacement(segment)
        return Span(segment.begin, segment.end, segment.time, segment.center, displacement, segment)

    def _displacement(self, segment: Segment) -> float:
        """Bound the displacement of all points of the group's shapes within a segment [m].

        The displacements by the joints that carry a shape add up (as in `PairDistances`).
        """
        plant = self._world.drake.plant
        plant.SetPositions(self._context, self._world.embed(self._group, segment.center))
        self._placed.update_poses(self._context)
        by_joint = self._bounds.max_displacements(
            self._placed.rotations,
            self._placed.positions,
            segment.max_rotation,
            segment.max_translation,
        )
        carried = np.where(self._bounds.is_carried_by, by_joint, 0.0)
        return float(carried.sum(axis=1).max(initial=0.0))
