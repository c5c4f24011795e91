"""Parts: a free motion and straight lines, timed each by itself and put together at rest.

start --free--> beginning of the approach --approach--> goal --retreat--> end
start --line--> first pose --line--> second pose ...
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from planning.candidates import Candidate
from planning.domain.cubic import cubic_through
from planning.domain.curve import TimedTrajectory
from planning.domain.funnel import Funnel
from planning.domain.goal import Goal, LineGoal, PoseGoal
from planning.domain.goal_configurations import GoalConfigurations
from planning.domain.joints import JointGroup
from planning.domain.line import MAX_SHIFT, MAX_TURN, GoalLegs, Leg, LineSection
from planning.domain.options import RetimeOptions
from planning.domain.path import JointPath
from planning.domain.plan import PlanPart
from planning.domain.problem import PlanningProblem
from planning.domain.report import RefineReport, RetimeReport
from planning.domain.search_report import SearchReport
from planning.errors import RetimingFailed
from planning.retime.audit import RATES
from planning.retime.path_limit import PathLimit
from planning.retime.path_limits import path_limits as asked_limits
from planning.retime.retimer import retime
from planning.world.tool_kinematics import ToolKinematics
from planning.world.world import Array, World

type PartKind = Literal["free", "approach", "retreat", "line"]

# Of motions that nobody refines.
NOT_REFINED = RefineReport("none", improved=False, reason="lines are followed as they are")
# Configurations between which the length of the tool's free way is measured.
_LOOKS = 33
# Durations that are less by this share are the same.
_SPARE = 1e-9


@dataclass(frozen=True)
class Part:
    """One timed part of a motion.

    Attributes:
        kind: What it is for.
        path: Its waypoints.
        trajectory: From rest to rest, beginning at time 0.
        leg: The line that it follows, if it does.
        report: How it was timed.
    """

    kind: PartKind
    path: JointPath
    trajectory: TimedTrajectory
    leg: Leg | None
    report: RetimeReport


def tool_of(group: JointGroup, goal: Goal) -> str:
    """Return the tool frame that a goal speaks of, or the group's default, or "" for none."""
    named = goal.frame if isinstance(goal, PoseGoal | LineGoal) else ""
    return named or next(iter(group.tool_frames), "")


def at_end_of(lines: Sequence[Leg]) -> GoalConfigurations:
    """Return the goal configuration that lines lead to, one after another."""
    end = lines[-1].positions[-1:]
    return GoalConfigurations(end, (len(lines) - 1,), Funnel(1, 1, 1, 1, 1, approach_ok=1))


def no_search(path: JointPath) -> SearchReport:
    """Return the report on a path that nobody searched for."""
    return SearchReport(
        planner="none",
        attempts=0,
        solved=0,
        num_states_checked=0,
        num_motions_checked=0,
        raw_length=path.length,
        length=path.length,
        num_waypoints=len(path.waypoints),
        resolution=0.0,
        padding=0.0,
        direct=True,
    )


def ends_of(goals: GoalConfigurations) -> Array:
    """Return where a motion to each goal configuration ends, shape (n, nq)."""
    retreats = [legs.retreat for legs in goals.legs if legs.retreat is not None]
    return np.stack([leg.positions[-1] for leg in retreats]) if retreats else goals.positions


def named_legs(legs: GoalLegs) -> list[tuple[PartKind, Leg]]:
    """Return the legs of a goal in the order in which they are followed."""
    named: list[tuple[PartKind, Leg]] = []
    if legs.approach is not None:
        named.append(("approach", legs.approach))
    if legs.retreat is not None:
        named.append(("retreat", legs.retreat))
    return named


def named_lines(legs: Sequence[Leg]) -> list[tuple[PartKind, Leg]]:
    """Return the legs of a line goal, named as such."""
    return [("line", leg) for leg in legs]


def freely_timed(problem: PlanningProblem) -> PlanningProblem:
    """Return a problem that leaves the duration open: it is asked of all parts together."""
    return replace(problem, retime=replace(problem.retime, duration=None))


def timed_legs(
    world: World,
    group: JointGroup,
    legs: Sequence[tuple[PartKind, Leg]],
    problem: PlanningProblem,
    begin: Array,
) -> tuple[Part, ...]:
    """Time legs one after another, each along a smooth curve through its waypoints.

    Args:
        world: The scene.
        group: What moves.
        legs: What they are for, and the legs.
        problem: Its options say how.
        begin: Where the first one begins, shape (nq,); whole turns of joints go on from here.

    Raises:
        RetimingFailed: A leg cannot be timed.
    """
    limits, parts = world.limits(group), list[Part]()
    others = asked_limits(world, group, problem.retime) if legs else ()
    for kind, leg in legs:
        rows = np.concatenate([begin[None], leg.positions])
        positions = JointPath(group, rows).continuous.waypoints[1:]
        curve = cubic_through(group.joints, leg.fractions, positions)
        trajectory, report = retime(curve, limits, freely_timed(problem).retime, others)
        count = max(problem.search.approach_states, len(positions))
        waypoints = curve.manifold.normalized(curve.positions(np.linspace(0.0, 1.0, count)))
        parts.append(Part(kind, JointPath(group, waypoints), trajectory, leg, report))
        begin = positions[-1]
    return tuple(parts)


def free_part(path: JointPath, candidate: Candidate) -> Part:
    """Return a candidate for the free way as a part."""
    return Part("free", path, candidate.trajectory, None, candidate.retime)


@dataclass(frozen=True)
class Motion:
    """All parts of a motion, at least one.

    Attributes:
        parts: In order.
    """

    parts: tuple[Part, ...]

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
            explanation=reports[0].explanation,
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
        return Motion(tuple(_slower(part, factor, path_limits) for part in self.parts))

    @property
    def _free(self) -> list[Part]:
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
    def _spans(self) -> list[tuple[Part, float, float]]:
        ends = np.cumsum([part.trajectory.duration for part in self.parts])
        begins = [0.0, *ends[:-1]]
        return [
            (part, float(begin), float(end))
            for part, begin, end in zip(self.parts, begins, ends, strict=True)
        ]


def _slower(part: Part, factor: float, path_limits: Sequence[PathLimit]) -> Part:
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


def _length(world: World, part: Part, frame: str) -> float:
    """Return how far a tool frame goes [m]; of a free part to within a few percent."""
    if part.leg is not None:
        return part.leg.line.length
    if not frame:
        return 0.0
    trajectory = part.trajectory
    q = trajectory.positions(np.linspace(0.0, trajectory.duration, _LOOKS))
    _, p_wt = ToolKinematics(world, part.path.group, frame).poses(q)
    return float(np.linalg.norm(np.diff(p_wt, axis=0), axis=1).sum())
