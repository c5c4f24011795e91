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
from planning.refine.constraints.clearance_objective import ClearanceCost, make_clearance_objective
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.retime.limits.path_limit import PathLimit
from planning.retime.retimer import retime
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World

# Share of the time for timing one more curve where there is a motion already.
_COMPARISON_TIME_FRACTION = 0.5


@dataclass(frozen=True)
class Candidate:
    """A timed motion that is not certified yet.

    Attributes:
        curve: What it follows.
        clearance_penalty: What falling short of the clearance that is wished for costs [s].
    """

    name: str
    curve: JointSpline
    trajectory: TimedTrajectory
    refine: RefineReport
    retime: RetimeReport
    clearance_penalty: float = 0.0

    @property
    def cost(self) -> float:
        """What is compared, the less the better [s]."""
        return self.trajectory.duration + self.clearance_penalty


@dataclass(frozen=True)
class _RetimeInputs:
    """How every curve is timed, and what was wrong with those that cannot be."""

    limits: JointLimits
    path_limits: tuple[PathLimit, ...]
    options: RetimeOptions
    watch: Stopwatch
    deadline: Deadline
    failures: list[RetimingFailed] = field(default_factory=list[RetimingFailed])

    @property
    def for_comparison(self) -> "_RetimeInputs":
        """The same for curves that are timed only to see whether they are quicker."""
        return replace(self, deadline=self.deadline.at_fraction(_COMPARISON_TIME_FRACTION))


def refine_and_proof_deadlines(
    problem: PlanningProblem, deadline: Deadline
) -> tuple[Deadline, Deadline]:
    """Return when to give up refining a path, and when timing and proving it.

    Who wants the best so far from a cancel gets it without refinement, but not without proof.
    """
    if problem.search.on_cancel == "discard":
        return deadline, deadline
    return deadline.expired_when_canceled, deadline.uncancelable


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
    refine_deadline, deadline = refine_and_proof_deadlines(problem, deadline)
    group, retime_options = world.group(problem.group), problem.retime
    limits = world.limits(group)
    retime_inputs = _RetimeInputs(limits, path_limits, retime_options, watch, deadline)
    with watch.stage("refine"):
        scaled = limits.scaled(retime_options.velocity_scale, retime_options.acceleration_scale)
        constraints = _compile_constraints(world, path, problem)
        request = RefineRequest(
            path,
            scaled,
            margins,
            problem.refine,
            jerk=retime_options.method == "ruckig",
            fixed_coordinates=_held_coordinates(group, problem.search),
            motion_limits=_motion_limits(retime_options),
            constraints=constraints
            and constraints.tightened(path.waypoints[0], path.waypoints[-1:]),
        )
        refined, report = refine(world, request, refine_deadline)
    timed = (
        [] if refined is None else _retime_spline("refined curve", refined, retime_inputs, report)
    )
    unrefined_report = replace(report, improved=False)
    if report.improved:
        unrefined_report = RefineReport(
            report.method,
            improved=False,
            reason="the unrefined path is quicker or safer",
            lower_bound=report.lower_bound,
        )
    # With jerk limits a wide corner may well be slower than a rest: all of them are compared.
    oracle = world.collision_oracle(group, margins)
    curves = collision_free_curves(path, retime_options, oracle, constraints)
    with watch.stage("retime"):
        first_curves = list(curves) if retime_options.method == "ruckig" else [next(curves)]
    new_candidates: list[Candidate] = []
    for i, curve in enumerate(first_curves):
        try:
            new_candidates = _retime_curve(
                curve, retime_inputs.for_comparison if timed else retime_inputs, unrefined_report
            )
        except DeadlineExceeded:
            # A motion that is timed is to be proven while there is time.
            if not timed:
                raise
            curves = chain(first_curves[i:], curves)
            break
        timed += new_candidates
    objective = refined and make_clearance_objective(
        world, group, margins, problem.refine.clearance
    )
    if objective is not None:
        timed = [_with_clearance_penalty(candidate, objective) for candidate in timed]
    yield from sorted(timed, key=lambda candidate: candidate.cost)
    # Looking whether a shape collides counts as timing it.
    for curve in watch.each("retime", curves):
        new_candidates = _retime_curve(curve, retime_inputs, unrefined_report)
        yield from new_candidates
    if not new_candidates:
        raise _retiming_failure(retime_inputs.failures)


def _with_clearance_penalty(candidate: Candidate, objective: ClearanceCost) -> Candidate:
    """Return a candidate that knows how far it falls short of the clearance wished for."""
    shortfall = objective.mean_shortfall(candidate.trajectory)
    report = replace(candidate.refine, shortfall=shortfall)
    return replace(candidate, refine=report, clearance_penalty=objective.weight * shortfall)


def _motion_limits(options: RetimeOptions) -> MotionLimits:
    return MotionLimits(
        options.tool_limits,
        options.speed_zones,
        options.acceleration_bounds,
        options.effort,
        options.payload,
    )


def _held_coordinates(group: JointGroup, search: SearchOptions) -> tuple[int, ...]:
    """Return the coordinates of rotations that the search was told to keep."""
    held_blocks = {
        f"{name}.angular" for name, space in search.spaces.items() if space == "position"
    }
    return tuple(i for name, indices in group.blocks if name in held_blocks for i in indices)


def _compile_constraints(
    world: World, path: JointPath, problem: PlanningProblem
) -> PathConstraints | None:
    if not problem.constraints:
        return None
    group = world.group(problem.group)
    return PathConstraints.compiled(world, group, problem.constraints, path.waypoints[0])


def _retime_curve(
    curve: PathCurve, retime_inputs: _RetimeInputs, report: RefineReport
) -> list[Candidate]:
    return [
        replace(candidate, retime=replace(candidate.retime, blend_deviation=curve.deviation))
        for candidate in _retime_spline(curve.name, curve.spline, retime_inputs, report)
    ]


def _retime_spline(
    name: str, spline: JointSpline, retime_inputs: _RetimeInputs, report: RefineReport
) -> list[Candidate]:
    """Time a curve; return nothing and remember why if it cannot be timed."""
    arguments = (
        retime_inputs.limits,
        retime_inputs.options,
        retime_inputs.path_limits,
        retime_inputs.deadline,
    )
    with retime_inputs.watch.stage("retime"):
        try:
            trajectory, retime_report = retime(spline, *arguments)
        except RetimingFailed as failure:
            retime_inputs.failures.append(failure)
            return []
    return [Candidate(name, spline, trajectory, report, retime_report)]


def _retiming_failure(failures: list[RetimingFailed]) -> RetimingFailed:
    """Return what to say once the path itself cannot be timed, which failed last.

    Rests at corners take time: if that is all that is wrong, the quickest curve says what is not.
    """
    last = failures[-1]
    if "least" not in last.evidence:
        message = f"the path cannot be timed, even with a rest at every corner: {last.detail}"
        return RetimingFailed(message, last.evidence)
    too_slow = [failure for failure in failures if "least" in failure.evidence]
    quickest = min(too_slow, key=lambda failure: failure.evidence["least"])
    return RetimingFailed(f"the path cannot be timed so: {quickest.detail}", quickest.evidence)
