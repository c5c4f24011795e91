"""Motion: sequence of segments joined at rest, with a common time scaling and report."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.linear_moves import (
    MAX_POSITION_DEVIATION,
    MAX_ROTATION_DEVIATION,
    LineSection,
)
from planning.domain.report.duration import DurationExplanation
from planning.domain.report.motion_plan import PlanPart
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import DeadlineExceeded, RetimingFailed
from planning.pipeline.segments import MotionSegment
from planning.retime.duration_explanation import explain_duration, join_explanations
from planning.retime.limit_utilization import RATES
from planning.retime.limits.path_limit import PathLimit
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Samples for the length of the tool's path along a free segment.
_NUM_LENGTH_SAMPLES = 33
# Relative difference up to which durations count as equal.
_DURATION_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Motion:
    """Motion as a sequence of segments.

    Attributes:
        segments: Segments in order, at least one.
    """

    segments: tuple[MotionSegment, ...]

    @property
    def trajectory(self) -> TimedTrajectory:
        """Trajectory of all segments, one after another."""
        return TimedTrajectory.joined([segment.trajectory for segment in self.segments])

    @property
    def path(self) -> JointPath:
        """Waypoints of all segments; where two segments meet there is one."""
        rows = [
            segment.path.waypoints if i == 0 else segment.path.waypoints[1:]
            for i, segment in enumerate(self.segments)
        ]
        first = self.segments[0].path
        return first if len(rows) == 1 else JointPath(first.group, np.concatenate(rows))

    @property
    def goal_configuration(self) -> Array:
        """Configuration at the goal, shape (nq,): at the end, or before a retreat."""
        reached = [segment for segment in self.segments if segment.kind != "retreat"]
        return reached[-1].trajectory.end if reached else self.segments[0].trajectory.start

    @property
    def report(self) -> RetimeReport:
        """Combined report of the retiming of all segments."""
        reports = [segment.report for segment in self.segments]
        if len(reports) == 1:
            return reports[0]
        raw = sum(report.duration / report.slowed for report in reports)
        duration = sum(report.duration for report in reports)
        worst = {
            rate: max(
                (report for report in reports if rate in report.utilisation),
                key=lambda report, rate=rate: report.utilisation[rate],
            )
            for rate in {rate: None for report in reports for rate in report.utilisation}
        }
        return RetimeReport(
            method=reports[0].method,
            duration=duration,
            slowed=duration / raw,
            binding={rate: report.binding[rate] for rate, report in worst.items()},
            utilisation={rate: report.utilisation[rate] for rate, report in worst.items()},
            stops=sum(report.stops for report in reports) + len(reports) - 1,
            blend_deviation=reports[0].blend_deviation,
            explanation=_combined_explanation(reports),
        )

    def with_duration(
        self, options: RetimeOptions, path_limits: Sequence[PathLimit] = ()
    ) -> "Motion":
        """Return the motion with all segments slowed by the same factor to a requested duration.

        Args:
            options: Options with the requested duration; None for the least.
            path_limits: Path limits with which the segments were timed.

        Raises:
            RetimingFailed: The requested duration is less than the limits allow.
        """
        min_duration = sum(segment.trajectory.duration for segment in self.segments)
        if options.duration is None or len(self.segments) == 1 == len(self._free_segments):
            return self
        if options.duration < min_duration * (1 - _DURATION_TOLERANCE):
            message = (
                f"the requested duration of {options.duration:.4g} s is shorter than the minimum "
                f"of {min_duration:.4g} s within the limits"
            )
            evidence = {
                "method": options.method,
                "duration": options.duration,
                "least": min_duration,
            }
            raise RetimingFailed(message, evidence)
        factor = max(1.0, options.duration / min_duration)
        if factor == 1.0:
            return self
        return Motion(tuple(_slowed(segment, factor, path_limits) for segment in self.segments))

    def with_explanation(
        self,
        limits: JointLimits,
        options: RetimeOptions,
        path_limits: Sequence[PathLimit],
        deadline: Deadline,
        *,
        may_be_slower: bool = False,
    ) -> "Motion":
        """Return the motion with reports that explain the duration of its segments.

        If the time runs out, the motion is returned without explanations.

        Args:
            limits: Unscaled joint limits with which the segments were timed.
            options: Options with which they were timed.
            path_limits: Path limits with which they were timed.
            deadline: Time limit of the explanation.
            may_be_slower: Whether the free segments may have been slowed by an objective.

        Raises:
            Canceled: Cancellation was requested.
        """
        explanations: list[DurationExplanation] = []
        try:
            for segment in self.segments:
                motion, stated = segment.trajectory, options
                if may_be_slower and segment.kind == "free":
                    stated = replace(options, duration=motion.duration)
                inputs = segment.curve, motion, limits, stated, path_limits, deadline
                explanations.append(explain_duration(*inputs))
        except DeadlineExceeded:
            return self
        return Motion(
            tuple(
                replace(segment, report=replace(segment.report, explanation=explanation))
                for segment, explanation in zip(self.segments, explanations, strict=True)
            )
        )

    @property
    def _free_segments(self) -> list[MotionSegment]:
        return [segment for segment in self.segments if segment.kind == "free"]

    def line_sections(
        self, max_shift: float = MAX_POSITION_DEVIATION, max_turn: float = MAX_ROTATION_DEVIATION
    ) -> tuple[LineSection, ...]:
        """Return the required tool lines of the straight segments.

        Args:
            max_shift: Largest distance of the tool from its line [m].
            max_turn: Largest rotation error of the tool [rad].
        """
        return tuple(
            LineSection(segment.move.line, begin, end, max_shift, max_turn)
            for segment, begin, end in self._spans
            if segment.move is not None
        )

    def summary(self, world: World, frame: str) -> tuple[PlanPart, ...]:
        """Return a summary of each segment; lengths are those of the path of a tool frame."""
        return tuple(
            PlanPart(
                segment.kind,
                begin,
                end,
                _tool_path_length(world, segment, frame),
                len(segment.path.waypoints),
            )
            for segment, begin, end in self._spans
        )

    @property
    def _spans(self) -> list[tuple[MotionSegment, float, float]]:
        ends = np.cumsum([segment.trajectory.duration for segment in self.segments])
        begins = [0.0, *ends[:-1]]
        return [
            (segment, float(begin), float(end))
            for segment, begin, end in zip(self.segments, begins, ends, strict=True)
        ]


def _slowed(
    segment: MotionSegment, factor: float, path_limits: Sequence[PathLimit]
) -> MotionSegment:
    """Return a segment that takes `factor` times as long."""
    report, trajectory = segment.report, segment.trajectory.time_scaled(factor)
    utilisation = {
        rate: report.utilisation[rate] / factor**order
        for order, rate in enumerate(RATES, start=1)
        if rate in report.utilisation
    }
    binding = {rate: report.binding[rate] for rate in utilisation}
    for limit in path_limits:
        for limit_utilization in limit.utilizations(trajectory):
            if limit_utilization.fraction_at(1.0) > utilisation.get(limit.name, -1.0):
                binding[limit.name] = limit_utilization.where
                utilisation[limit.name] = limit_utilization.fraction_at(1.0)
    slowed_report = replace(
        report, duration=report.duration * factor, binding=binding, utilisation=utilisation
    )
    return replace(segment, trajectory=trajectory, report=slowed_report)


def _combined_explanation(reports: Sequence[RetimeReport]) -> DurationExplanation | None:
    """Return the explanation of the whole duration; None if none was requested."""
    explanations = [
        (report.explanation, report.duration)
        for report in reports
        if report.explanation is not None
    ]
    return join_explanations(explanations) if explanations else None


def _tool_path_length(world: World, segment: MotionSegment, frame: str) -> float:
    """Return the length of a tool frame's path [m]; of a free segment to within a few percent."""
    if segment.move is not None:
        return segment.move.line.length
    if not frame:
        return 0.0
    trajectory = segment.trajectory
    q = trajectory.positions(np.linspace(0.0, trajectory.duration, _NUM_LENGTH_SAMPLES))
    _, p_wt = ToolKinematics(world, segment.path.group, frame).poses(q)
    return float(np.linalg.norm(np.diff(p_wt, axis=0), axis=1).sum())
