"""Candidates: the motions that one path can become, quickest first."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import chain

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RefineReport, RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import MotionLimits
from planning.domain.request.options import RetimeOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.errors import DeadlineExceeded, RetimingFailed
from planning.pipeline.path_curves import PathCurve, collision_free_curves
from planning.refine.constraints.clearance_objective import ClearanceObjective, clearance_objective
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.retime.limits.path_limit import PathLimit
from planning.retime.retimer import retime
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World

# Share of the time for timing one more curve where there is a motion already.
_COMPARING_SHARE = 0.5


@dataclass(frozen=True)
class Candidate:
    """A timed motion that is not certified yet.

    Attributes:
        curve: What it follows.
        lacking: What falling short of the clearance that is wished for costs [s].
    """

    name: str
    curve: JointSpline
    trajectory: TimedTrajectory
    refine: RefineReport
    retime: RetimeReport
    lacking: float = 0.0

    @property
    def worth(self) -> float:
        """What is compared, the less the better [s]."""
        return self.trajectory.duration + self.lacking


@dataclass(frozen=True)
class _Timing:
    """How every curve is timed, and what was wrong with those that cannot be."""

    limits: JointLimits
    path_limits: tuple[PathLimit, ...]
    options: RetimeOptions
    watch: Stopwatch
    deadline: Deadline
    failed: list[RetimingFailed] = field(default_factory=list[RetimingFailed])

    @property
    def hasty(self) -> "_Timing":
        """The same for curves that are timed only to see whether they are quicker."""
        return replace(self, deadline=self.deadline.share(_COMPARING_SHARE))


def deadlines(problem: PlanningProblem, deadline: Deadline) -> tuple[Deadline, Deadline]:
    """Return when to give up refining a path, and when timing and proving it.

    Who wants the best so far from a cancel gets it without refinement, but not without proof.
    """
    if problem.search.on_cancel == "discard":
        return deadline, deadline
    return deadline.over_when_canceled, deadline.uncancelable


def candidates(  # noqa: PLR0913  (a question in full)
    world: World,
    path: JointPath,
    problem: PlanningProblem,
    margins: PairMargins,
    deadline: Deadline,
    watch: Stopwatch,
    *,
    path_limits: tuple[PathLimit, ...],
) -> Iterator[Candidate]:
    """Yield timed motions along a path: the better of refined and rounded first.

    Raises:
        RetimingFailed: After all others, not even the path itself, with a rest at every corner, can
            be timed. Where a duration was asked for, evidence has the least of all that failed.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    hasty, deadline = deadlines(problem, deadline)
    group, retime_options = world.group(problem.group), problem.retime
    limits = world.limits(group)
    timing = _Timing(limits, path_limits, retime_options, watch, deadline)
    with watch.stage("refine"):
        scaled = limits.scaled(retime_options.velocity_scale, retime_options.acceleration_scale)
        rules = _rules(world, path, problem)
        request = RefineRequest(
            path,
            scaled,
            margins,
            problem.refine,
            jerk=retime_options.method == "ruckig",
            held=_held(group, problem.search),
            others=_others(retime_options),
            rules=rules and rules.leaving_room(path.waypoints[0], path.waypoints[-1:]),
        )
        refined, report = refine(world, request, hasty)
    first = [] if refined is None else _timed("refined curve", refined, timing, report)
    unrefined = replace(report, improved=False)
    if report.improved:
        unrefined = RefineReport(
            report.method,
            improved=False,
            reason="the unrefined path is quicker or safer",
            lower_bound=report.lower_bound,
        )
    # With jerk limits a wide corner may well be slower than a rest: all of them are compared.
    oracle = world.collision_oracle(group, margins)
    clear = collision_free_curves(path, retime_options, oracle, rules)
    with watch.stage("retime"):
        compared = list(clear) if retime_options.method == "ruckig" else [next(clear)]
    made: list[Candidate] = []
    for i, shape in enumerate(compared):
        try:
            made = _shaped(shape, timing.hasty if first else timing, unrefined)
        except DeadlineExceeded:
            # A motion that is timed is to be proven while there is time.
            if not first:
                raise
            clear = chain(compared[i:], clear)
            break
        first += made
    wish = refined and clearance_objective(world, group, margins, problem.refine.clearance)
    if wish is not None:
        first = [_wished(candidate, wish) for candidate in first]
    yield from sorted(first, key=lambda candidate: candidate.worth)
    # Looking whether a shape collides counts as timing it.
    for shape in watch.each("retime", clear):
        made = _shaped(shape, timing, unrefined)
        yield from made
    if not made:
        raise _untimed(timing.failed)


def _wished(candidate: Candidate, wish: ClearanceObjective) -> Candidate:
    """Return a candidate that knows how far it falls short of the clearance wished for."""
    shortfall = wish.shortfall(candidate.trajectory)
    report = replace(candidate.refine, shortfall=shortfall)
    return replace(candidate, refine=report, lacking=wish.weight * shortfall)


def _others(options: RetimeOptions) -> MotionLimits:
    return MotionLimits(
        options.tool_limits,
        options.speed_zones,
        options.acceleration_bounds,
        options.effort,
        options.payload,
    )


def _held(group: JointGroup, search: SearchOptions) -> tuple[int, ...]:
    """Return the coordinates of rotations that the search was told to keep."""
    kept = {f"{name}.angular" for name, space in search.spaces.items() if space == "position"}
    return tuple(i for name, indices in group.blocks if name in kept for i in indices)


def _rules(world: World, path: JointPath, problem: PlanningProblem) -> PathConstraints | None:
    if not problem.constraints:
        return None
    group = world.group(problem.group)
    return PathConstraints.compiled(world, group, problem.constraints, path.waypoints[0])


def _shaped(shape: PathCurve, timing: _Timing, report: RefineReport) -> list[Candidate]:
    return [
        replace(made, retime=replace(made.retime, blend_deviation=shape.deviation))
        for made in _timed(shape.name, shape.spline, timing, report)
    ]


def _timed(
    name: str, spline: JointSpline, timing: _Timing, report: RefineReport
) -> list[Candidate]:
    """Time a curve; return nothing and remember why if it cannot be timed."""
    how = timing.limits, timing.options, timing.path_limits, timing.deadline
    with timing.watch.stage("retime"):
        try:
            trajectory, done = retime(spline, *how)
        except RetimingFailed as fault:
            timing.failed.append(fault)
            return []
    return [Candidate(name, spline, trajectory, report, done)]


def _untimed(failed: list[RetimingFailed]) -> RetimingFailed:
    """Return what to say once the path itself cannot be timed, which failed last.

    Rests at corners take time: if that is all that is wrong, the quickest curve says what is not.
    """
    last = failed[-1]
    if "least" not in last.evidence:
        message = f"the path cannot be timed, even with a rest at every corner: {last.detail}"
        return RetimingFailed(message, last.evidence)
    too_slow = [fault for fault in failed if "least" in fault.evidence]
    quickest = min(too_slow, key=lambda fault: fault.evidence["least"])
    return RetimingFailed(f"the path cannot be timed so: {quickest.detail}", quickest.evidence)
