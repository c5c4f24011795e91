"""Candidates: timed motions along one path, not certified yet, the best by the objective first."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import MotionLimits
from planning.domain.request.options import RefineOptions, RetimeOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup
from planning.errors import DeadlineExceeded
from planning.pipeline.timing.candidate_order import cheapest_first
from planning.pipeline.timing.candidate_timing import CandidateMotion, CandidateTiming
from planning.pipeline.timing.path_curves import PathCurve, collision_free_curves
from planning.refine.constraints.clearance_objective import ClearanceCost, make_clearance_objective
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.retime.limits.path_limit import PathLimit
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World

# Share of a requested duration that an optimized motion leaves for the retimer's tolerances.
_TIME_RESERVE = 1e-5


def refine_and_proof_deadlines(
    problem: PlanningProblem, deadline: Deadline
) -> tuple[Deadline, Deadline]:
    """Return the deadline of refinement, and the deadline of retiming and certification.

    If a canceled plan is to return the best motion so far, a cancellation ends refinement only.
    """
    if problem.search.on_cancel == "discard":
        return deadline, deadline
    return deadline.expired_when_canceled, deadline.uncancelable


def candidates(  # noqa: PLR0913  (all inputs of two stages)
    world: World,
    path: JointPath,
    problem: PlanningProblem,
    margins: PairMargins,
    deadline: Deadline,
    watch: Stopwatch,
    *,
    path_limits: tuple[PathLimit, ...],
    longest: float | None = None,
) -> Iterator[CandidateMotion]:
    """Yield timed motions along a path: the better of the refined and the rounded curve first.

    By an objective other than the duration they take no longer than `longest` [s] if they need not;
    None for no such limit.

    Raises:
        RetimingFailed: After all other curves the path itself, with a rest at every corner, cannot
            be timed either. If the requested duration is too short, evidence has the least duration
            of all curves.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    refine_deadline, deadline = refine_and_proof_deadlines(problem, deadline)
    group, retime_options = world.group(problem.group), problem.retime
    limits = world.limits(group)
    timing = CandidateTiming(
        world, group, path_limits, retime_options, problem.refine, watch, deadline, longest
    )
    with watch.stage("refine"):
        scaled = limits.scaled(retime_options.velocity_scale, retime_options.acceleration_scale)
        constraints = _compile_constraints(world, path, problem)
        request = RefineRequest(
            path,
            scaled,
            margins,
            _bounded(problem.refine, longest),
            limits_jerk=retime_options.limits_jerk,
            fixed_coordinates=_fixed_coordinates(group, problem.search),
            motion_limits=_motion_limits(retime_options),
            constraints=constraints
            and constraints.tightened(path.waypoints[0], path.waypoints[-1:]),
        )
        refined, report = refine(world, request, refine_deadline)
    timed = timing.refined(refined, report)
    unrefined_report = report
    if report.improved:
        unrefined_report = RefineReport(
            report.method,
            improved=False,
            reason="the unrefined path is quicker or safer",
            lower_bound=report.lower_bound,
        )
    # With jerk limits a wide corner may be slower than a rest: all curves are compared.
    oracle = world.collision_oracle(group, margins)
    curves = collision_free_curves(path, retime_options, oracle, constraints, deadline)
    with watch.stage("retime"):
        first_curves = list(curves) if retime_options.limits_jerk else [next(curves)]
    compared, slower, results, is_cut = _along_path(timing, first_curves, timed, unrefined_report)
    outcomes = {curve.name: found for curve, found in zip(compared, results, strict=False)}
    along_path = list(chain.from_iterable(results))
    before = timing.values(along_path)
    objective = refined and make_clearance_objective(
        world, group, margins, problem.refine.clearance
    )

    def weighed(found: list[CandidateMotion]) -> list[CandidateMotion]:
        found = timing.weighed(found, before)
        if objective is None:
            return found
        return [_with_clearance_penalty(candidate, objective) for candidate in found]

    def time_curve(curve: PathCurve, is_compared: bool) -> list[CandidateMotion]:  # noqa: FBT001
        settings = timing.for_comparison if is_compared else timing
        outcomes[curve.name] = weighed(settings.along_path(curve, unrefined_report))
        return outcomes[curve.name]

    timed = weighed([*timed, *along_path])
    # The collision check of a curve counts as retiming.
    further = chain(compared[len(results) :], watch.each("retime", curves))
    last = yield from cheapest_first(timed, further, time_curve, slower=slower, compares=not is_cut)
    if last is None:
        last = outcomes.get(first_curves[-1].name, []) if timed else []
    if not last:
        raise timing.failure


def _along_path(
    timing: CandidateTiming,
    curves: list[PathCurve],
    timed: list[CandidateMotion],
    report: RefineReport,
) -> tuple[list[PathCurve], list[PathCurve], list[list[CandidateMotion]], bool]:
    """Time curves one by one, where they may be quicker than what was timed before.

    Returns:
        The curves to compare, those that are certainly slower, the candidates of the former as far
        as the time to compare lasts, and whether it ended before.
    """
    compared: list[PathCurve] = []
    slower: list[PathCurve] = []
    results: list[list[CandidateMotion]] = []
    is_cut = False
    timed = list(timed)
    for curve in curves:
        quickest = min(timed, key=lambda candidate: candidate.trajectory.duration, default=None)
        if quickest is not None and timing.is_certainly_slower(curve, quickest):
            slower.append(curve)
            continue
        compared.append(curve)
        if is_cut:
            continue
        try:
            found = (timing.for_comparison if timed else timing).along_path(curve, report)
        except DeadlineExceeded:
            # The remaining time is for certifying the motion that is timed already.
            if not timed:
                raise
            is_cut = True
        else:
            results.append(found)
            timed += found
    return compared, slower, results, is_cut


def _with_clearance_penalty(motion: CandidateMotion, objective: ClearanceCost) -> CandidateMotion:
    """Return a candidate with the penalty of its clearance shortfall."""
    shortfall = objective.mean_shortfall(motion.trajectory)
    report = replace(motion.refine, shortfall=shortfall)
    return replace(motion, refine=report, clearance_penalty=objective.weight * shortfall)


def _motion_limits(options: RetimeOptions) -> MotionLimits:
    return MotionLimits(
        options.tool_limits,
        options.speed_zones,
        options.acceleration_bounds,
        options.effort,
        options.payload,
    )


def _bounded(options: RefineOptions, longest: float | None) -> RefineOptions:
    """Return options whose objective leaves a reserve for what the retimer slows."""
    if options.objective is None or longest is None:
        return options
    return replace(options, objective=options.objective.within(longest * (1 - _TIME_RESERVE)))


def _fixed_coordinates(group: JointGroup, search: SearchOptions) -> tuple[int, ...]:
    """Return the velocity coordinates of rotations that the search space keeps fixed."""
    fixed_blocks = {
        f"{name}.angular" for name, space in search.spaces.items() if space == "position"
    }
    return tuple(i for name, indices in group.blocks if name in fixed_blocks for i in indices)


def _compile_constraints(
    world: World, path: JointPath, problem: PlanningProblem
) -> PathConstraints | None:
    if not problem.constraints:
        return None
    group = world.group(problem.group)
    return PathConstraints.compiled(world, group, problem.constraints, path.waypoints[0])
