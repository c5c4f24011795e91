"""CollisionPairs: timed motions along one path, not certified yet, quickest first."""

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

# Share of the time for timing another curve when there is a timed motion already.
_COMPARISON_TIME_FRACTION = 0.5


@dataclass(frozen=True)
class CandidateMotion:
    """Timed motion that is not certified yet.

    Attributes:
        name: Name of the curve, for messages and reports.
        curve: Geometric curve that the motion follows.
        trajectory: The motion.
        refine: Report of the refinement.
        retime: Report of the retiming.
        clearance_penalty: Cost of clearance below the clearance objective's distance [s].
    """

    name: str
    curve: JointSpline
    trajectory: TimedTrajectory
    refine: RefineReport
    retime: RetimeReport
    clearance_penalty: float = 0.0

    @property
    def cost(self) -> float:
        """Duration plus clearance penalty, by which candidates are compared [s]."""
        return self.trajectory.duration + self.clearance_penalty


@dataclass(frozen=True)
class _RetimeInputs:
    """Inputs of the retiming of every curve, and the failures so far."""

    limits: JointLimits
    path_limits: tuple[PathLimit, ...]
    options: RetimeOptions
    watch: Stopwatch
    deadline: Deadline
    failures: list[RetimingFailed] = field(default_factory=list[RetimingFailed])

    @property
    def for_comparison(self) -> "_RetimeInputs":
        """The same inputs with less time, for curves that may only improve on a timed motion."""
        return replace(self, deadline=self.deadline.at_fraction(_COMPARISON_TIME_FRACTION))


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
) -> Iterator[CandidateMotion]:
    """Yield timed motions along a path: the better of the refined and the rounded curve first.

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
    retime_inputs = _RetimeInputs(limits, path_limits, retime_options, watch, deadline)
    with watch.stage("refine"):
        scaled = limits.scaled(retime_options.velocity_scale, retime_options.acceleration_scale)
        constraints = _compile_constraints(world, path, problem)
        request = RefineRequest(
            path,
            scaled,
            margins,
            problem.refine,
            jerk=retime_options.limits_jerk,
            fixed_coordinates=_fixed_coordinates(group, problem.search),
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
    # With jerk limits a wide corner may be slower than a rest: all curves are compared.
    oracle = world.collision_oracle(group, margins)
    curves = collision_free_curves(path, retime_options, oracle, constraints)
    with watch.stage("retime"):
        first_curves = list(curves) if retime_options.limits_jerk else [next(curves)]
    new_candidates: list[CandidateMotion] = []
    for i, curve in enumerate(first_curves):
        try:
            new_candidates = _retime_curve(
                curve, retime_inputs.for_comparison if timed else retime_inputs, unrefined_report
            )
        except DeadlineExceeded:
            # The remaining time is for certifying the motion that is timed already.
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
    # The collision check of a curve counts as retiming.
    for curve in watch.each("retime", curves):
        new_candidates = _retime_curve(curve, retime_inputs, unrefined_report)
        yield from new_candidates
    if not new_candidates:
        raise _retiming_failure(retime_inputs.failures)


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


def _retime_curve(
    curve: PathCurve, retime_inputs: _RetimeInputs, report: RefineReport
) -> list[CandidateMotion]:
    return [
        replace(candidate, retime=replace(candidate.retime, blend_deviation=curve.deviation))
        for candidate in _retime_spline(curve.name, curve.spline, retime_inputs, report)
    ]


def _retime_spline(
    name: str, spline: JointSpline, retime_inputs: _RetimeInputs, report: RefineReport
) -> list[CandidateMotion]:
    """Return the candidate along a curve; if it cannot be timed, store the failure, return none."""
    with retime_inputs.watch.stage("retime"):
        try:
            trajectory, retime_report = retime(
                spline,
                retime_inputs.limits,
                retime_inputs.options,
                retime_inputs.path_limits,
                retime_inputs.deadline,
            )
        except RetimingFailed as failure:
            retime_inputs.failures.append(failure)
            return []
    return [CandidateMotion(name, spline, trajectory, report, retime_report)]


def _retiming_failure(failures: list[RetimingFailed]) -> RetimingFailed:
    """Return the failure of retiming all curves; the last one is that of the path itself.

    If that is only slower than the requested duration, because of its rests at corners, the failure
    of the curve with the least duration is returned.
    """
    last = failures[-1]
    if "least" not in last.evidence:
        message = f"the path cannot be timed, even with a rest at every corner: {last.detail}"
        return RetimingFailed(message, last.evidence)
    too_slow = [failure for failure in failures if "least" in failure.evidence]
    quickest = min(too_slow, key=lambda failure: failure.evidence["least"])
    message = f"no curve along the path can be timed as requested: {quickest.detail}"
    return RetimingFailed(message, quickest.evidence)
