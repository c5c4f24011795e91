"""Motion: parts put together at rest, slowed alike and described."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.linear_moves import MAX_SHIFT, MAX_TURN, LineSection
from planning.domain.report.duration import DurationExplanation
from planning.domain.report.motion_plan import PlanPart
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits
from planning.errors import DeadlineExceeded, RetimingFailed
from planning.pipeline.segments import MotionSegment
from planning.retime.explain import explain_duration, joined_explanation
from planning.retime.limit_utilization import RATES
from planning.retime.limits.path_limit import PathLimit
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import Array, World

# Configurations between which the length of the tool's free way is measured.
_LOOKS = 33
# Durations that are less by this share are the same.
_SPARE = 1e-9


@dataclass(frozen=True)
class Motion:
    """All parts of a motion, at least one.

    Attributes:
        parts: In order.
    """

    parts: tuple[MotionSegment, ...]

    @property
    def trajectory(self) -> TimedTrajectory:
        """The parts, one after another."""
        return TimedTrajectory.joined([part.trajectory for part in self.parts])

    @property
    def path(self) -> JointPath:
        """The waypoints of all parts; where two meet there is one."""
        rows = [
            part.path.waypoints if i == 0 else part.path.waypoints[1:]
            for i, part in enumerate(self.parts)
        ]
        first = self.parts[0].path
        return first if len(rows) == 1 else JointPath(first.group, np.concatenate(rows))

    @property
    def goal_configuration(self) -> Array:
        """Where the goal is reached: at the end, but for a retreat."""
        reached = [part for part in self.parts if part.kind != "retreat"]
        return reached[-1].trajectory.end if reached else self.parts[0].trajectory.start

    @property
    def report(self) -> RetimeReport:
        """How all of it was timed."""
        reports = [part.report for part in self.parts]
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
            explanation=_explained(reports),
        )

    def lasting(self, options: RetimeOptions, path_limits: Sequence[PathLimit] = ()) -> "Motion":
        """Return the motion with all parts slowed alike to the duration that is asked for.

        Args:
            options: Say how long it shall take.
            path_limits: With which the parts were timed.

        Raises:
            RetimingFailed: That would be quicker than the limits allow.
        """
        least = sum(part.trajectory.duration for part in self.parts)
        if options.duration is None or len(self.parts) == 1 == len(self._free):
            return self
        if options.duration < least * (1 - _SPARE):
            message = f"the limits allow {least:.4g} s at least, not {options.duration:.4g} s"
            evidence = {"method": options.method, "duration": options.duration, "least": least}
            raise RetimingFailed(message, evidence)
        factor = max(1.0, options.duration / least)
        if factor == 1.0:
            return self
        return Motion(tuple(_slower(part, factor, path_limits) for part in self.parts))

    def explained(
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
        how = limits, options, path_limits, deadline
        try:
            told = [explain_duration(part.curve, part.trajectory, *how) for part in self.parts]
        except DeadlineExceeded:
            return self
        return Motion(
            tuple(
                replace(part, report=replace(part.report, explanation=explanation))
                for part, explanation in zip(self.parts, told, strict=True)
            )
        )

    @property
    def _free(self) -> list[MotionSegment]:
        return [part for part in self.parts if part.kind == "free"]

    def sections(
        self, max_shift: float = MAX_SHIFT, max_turn: float = MAX_TURN
    ) -> tuple[LineSection, ...]:
        """Return what is demanded of the parts that follow lines."""
        return tuple(
            LineSection(part.leg.line, begin, end, max_shift, max_turn)
            for part, begin, end in self._spans
            if part.leg is not None
        )

    def described(self, world: World, frame: str) -> tuple[PlanPart, ...]:
        """Return what there is to say of each part; lengths are those of a tool frame's way."""
        return tuple(
            PlanPart(part.kind, begin, end, _length(world, part, frame), len(part.path.waypoints))
            for part, begin, end in self._spans
        )

    @property
    def _spans(self) -> list[tuple[MotionSegment, float, float]]:
        ends = np.cumsum([part.trajectory.duration for part in self.parts])
        begins = [0.0, *ends[:-1]]
        return [
            (part, float(begin), float(end))
            for part, begin, end in zip(self.parts, begins, ends, strict=True)
        ]


def _slower(part: MotionSegment, factor: float, path_limits: Sequence[PathLimit]) -> MotionSegment:
    """Return a part that takes `factor` times as long."""
    report, trajectory = part.report, part.trajectory.slowed(factor)
    used = {
        rate: report.utilisation[rate] / factor**order
        for order, rate in enumerate(RATES, start=1)
        if rate in report.utilisation
    }
    binding = {rate: report.binding[rate] for rate in used}
    for limit in path_limits:
        for use in limit.uses(trajectory):
            if use.share(1.0) > used.get(limit.name, -1.0):
                binding[limit.name], used[limit.name] = use.where, use.share(1.0)
    made = replace(report, duration=report.duration * factor, binding=binding, utilisation=used)
    return replace(part, trajectory=trajectory, report=made)


def _explained(reports: Sequence[RetimeReport]) -> DurationExplanation | None:
    """Return why all parts together take as long as they do, if that was asked for."""
    told = [
        (report.explanation, report.duration)
        for report in reports
        if report.explanation is not None
    ]
    return joined_explanation(told) if told else None


def _length(world: World, part: MotionSegment, frame: str) -> float:
    """Return how far a tool frame goes [m]; of a free part to within a few percent."""
    if part.leg is not None:
        return part.leg.line.length
    if not frame:
        return 0.0
    trajectory = part.trajectory
    q = trajectory.positions(np.linspace(0.0, trajectory.duration, _LOOKS))
    _, p_wt = ToolKinematics(world, part.path.group, frame).poses(q)
    return float(np.linalg.norm(np.diff(p_wt, axis=0), axis=1).sum())
