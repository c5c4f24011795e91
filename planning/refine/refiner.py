"""refine(): trajectory optimization of a path: a smooth, quick, free curve, or none and the reason.

Sequential convex programming in a trust region, with distances under an exact penalty (Schulman et
al., "Motion planning with sequential convex optimization and convex collision checking", IJRR 33:9,
2014): see `model/curve_model` and `trust_region`, for cars `cars/`. Every curve that is better than
those before it is audited densely; where it violates a margin between the instants at which
distances are kept, those instants are added.
"""

from dataclasses import replace

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.domain.robot.steering import steering_of
from planning.refine.cars.drive_refiner import refine_drive
from planning.refine.curve_checks import curve_length
from planning.refine.curves.chart import FlatChart, make_chart
from planning.refine.model.penalty_qp import solver_name
from planning.refine.multi_start import solve_multi_start
from planning.refine.refine_problem import RefineProblem
from planning.refine.request import RefineRequest
from planning.world.world import World

# Least remaining time of a plan for the method "auto" to refine [s].
_MIN_REMAINING_TIME = 0.5
# Share of the remaining time that this stage may use.
_TIME_SHARE = 0.35


def refine(
    world: World, request: RefineRequest, deadline: Deadline
) -> tuple[JointSpline | None, RefineReport]:
    """Return a curve from the path's start to its goal that should take less time, if there is one.

    Not promised: that the curve is free between the audited samples, or that its motion is faster
    than that along the path. The caller times and certifies both.

    Args:
        world: The scene, loaded.
        request: Path, limits, margins and constraints.
        deadline: Deadline of the whole plan; a share of the remaining time is used.

    Returns:
        The curve (arcs and lines of a car), or None if the path is to be used; and a report with
            the reason.
    """
    path = request.path
    report = RefineReport(request.options.method, improved=False, length_before=path.length)
    stage_deadline = deadline.at_fraction(_TIME_SHARE)
    skip_reason = _skip_reason(request, stage_deadline)
    if skip_reason:
        return None, replace(report, reason=skip_reason)
    if steering_of(path.group):
        return refine_drive(world, request, stage_deadline, report)
    return _refine_curve(world, request, stage_deadline, report)


def _refine_curve(
    world: World, request: RefineRequest, deadline: Deadline, report: RefineReport
) -> tuple[JointSpline | None, RefineReport]:
    """Return a curve near a path of joints without steering."""
    problem = RefineProblem.of(world, request, deadline)
    report = replace(report, solver=solver_name(), lower_bound=problem.lower_bound)
    if not problem.is_static_load_feasible:
        return None, replace(
            report, reason="the static torque exceeds an effort limit at the start or the goal"
        )
    result = solve_multi_start(world, problem)
    best = result.best
    report = replace(
        report, rounds=result.num_steps, duration_before=problem.duration_of(result.first_guess)
    )
    if best is not None and result.num_steps == 0 and len(problem.waypoints) == 2:
        return None, replace(report, reason="the straight path is already optimal")
    if best is None:
        return None, replace(report, reason=result.reason)
    curve = result.problem.curve_of(best)
    return curve, replace(
        report, improved=True, length_after=curve_length(curve), duration_after=best.duration
    )


def _skip_reason(request: RefineRequest, deadline: Deadline) -> str:
    """Return why no refinement begins, or ""."""
    if request.options.method == "none":
        return "refine.method is none"
    unsupported_reason = _unsupported_reason(request.path)
    if unsupported_reason:
        return unsupported_reason
    if request.options.method == "auto" and deadline.remaining < _TIME_SHARE * _MIN_REMAINING_TIME:
        deadline.on_expiry()
        return f"method auto: less than {_MIN_REMAINING_TIME:g} s of planning time remained"
    return "the deadline passed before refinement began" if deadline.is_over else ""


def _unsupported_reason(path: JointPath) -> str:
    """Return why a path cannot be refined, or ""."""
    chart, num_cars = make_chart(path), len(steering_of(path.group))
    if num_cars > 1 or (num_cars and not isinstance(chart, FlatChart)):
        return "groups with several cars, or with a car and a floating joint, are not refined"
    if len(chart.waypoints) < 2:
        return "the path has zero length"
    return ""
