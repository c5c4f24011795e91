"""Motion: parts put together at rest, slowed alike and described."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

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
from planning.world.world import Array, World

# Configurations between which the length of the tool's free way is measured.
_NUM_LENGTH_SAMPLES = 33
# Durations that are less by this share are the same.
_DURATION_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Motion:
    """All parts of a motion, at least one.

    Attributes:
        segments: In order.
    """

    segments: tuple[MotionSegment, ...]

    @property
    def trajectory(self) -> TimedTrajectory:
        """The parts, one after another."""
        return TimedTrajectory.joined([segment.trajectory for segment in self.segments])

    @property
    def path(self) -> JointPath:
        """The waypoints of all parts; where two meet there is one."""
        rows = [
            segment.path.waypoints if i == 0 else segment.path.waypoints[1:]
            for i, segment in enumerate(self.segments)
        ]
        first = self.segments[0].path
        return first if len(rows) == 1 else JointPath(first.group, np.concatenate(rows))

    @property
    def goal_configuration(self) -> Array:
        """Where the goal is reached: at the end, but for a retreat."""
        reached = [segment for segment in self.segments if segment.kind != "retreat"]
        return reached[-1].trajectory.end if reached else self.segments[0].trajectory.start

    @property
    def report(self) -> RetimeReport:
        """How all of it was timed."""
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
        """Return the motion with all parts slowed alike to the duration that is asked for.

        Args:
            options: Say how long it shall take.
            path_limits: With which the parts were timed.

        Raises:
            RetimingFailed: That would be quicker than the limits allow.
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
        return Motion(tuple(_slowed(part, factor, path_limits) for part in self.segments))

    def with_explanation(
        self,
        limits: JointLimits,
        options: RetimeOptions,
        path_limits: Sequence[PathLimit],
        deadline: Deadline,
    ) -> "Motion":
        """Return the motion with reports that say why its parts take as long as they do.

        If the time runs out it is the motion as it was, which is worth more than its explanation.

        Args:
            limits: With which the parts were timed, unscaled.
            options: And with which options.
            path_limits: And with which limits besides.
            deadline: When to give up.

        Raises:
            Canceled: The end was asked for.
        """
        retime_inputs = limits, options, path_limits, deadline
        try:
            explanations = [
                explain_duration(segment.curve, segment.trajectory, *retime_inputs)
                for segment in self.segments
            ]
        except DeadlineExceeded:
            return self
        return Motion(
            tuple(
                replace(part, report=replace(part.report, explanation=explanation))
                for part, explanation in zip(self.segments, explanations, strict=True)
            )
        )

    @property
    def _free_segments(self) -> list[MotionSegment]:
        return [segment for segment in self.segments if segment.kind == "free"]

    def line_sections(
        self, max_shift: float = MAX_POSITION_DEVIATION, max_turn: float = MAX_ROTATION_DEVIATION
    ) -> tuple[LineSection, ...]:
        """Return what is demanded of the parts that follow lines."""
        return tuple(
            LineSection(segment.move.line, begin, end, max_shift, max_turn)
            for segment, begin, end in self._spans
            if segment.move is not None
        )

    def summary(self, world: World, frame: str) -> tuple[PlanPart, ...]:
        """Return what there is to say of each part; lengths are those of a tool frame's way."""
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
            (part, float(begin), float(end))
            for part, begin, end in zip(self.segments, begins, ends, strict=True)
        ]


def _slowed(
    segment: MotionSegment, factor: float, path_limits: Sequence[PathLimit]
) -> MotionSegment:
    """Return a part that takes `factor` times as long."""
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
                binding[limit.name], utilisation[limit.name] = (
                    limit_utilization.where,
                    limit_utilization.fraction_at(1.0),
                )
    slowed_report = replace(
        report, duration=report.duration * factor, binding=binding, utilisation=utilisation
    )
    return replace(segment, trajectory=trajectory, report=slowed_report)


def _combined_explanation(reports: Sequence[RetimeReport]) -> DurationExplanation | None:
    """Return why all parts together take as long as they do, if that was asked for."""
    explanations = [
        (report.explanation, report.duration)
        for report in reports
        if report.explanation is not None
    ]
    return join_explanations(explanations) if explanations else None


def _tool_path_length(world: World, segment: MotionSegment, frame: str) -> float:
    """Return how far a tool frame goes [m]; of a free part to within a few percent."""
    if segment.move is not None:
        return segment.move.line.length
    if not frame:
        return 0.0
    trajectory = segment.trajectory
    q = trajectory.positions(np.linspace(0.0, trajectory.duration, _NUM_LENGTH_SAMPLES))
    _, p_wt = ToolKinematics(world, segment.path.group, frame).poses(q)
    return float(np.linalg.norm(np.diff(p_wt, axis=0), axis=1).sum())
