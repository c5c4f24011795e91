"""refine(): trajectory optimisation of a path: a smooth, quick, free curve, or none and the reason.

Sequential convex programming in a trust region, with distances under an exact penalty (Schulman et
al., "Motion planning with sequential convex optimization and convex collision checking", IJRR 33:9,
2014): see `model/curve_model` and `trust_region`, for cars `cars/`. Every curve that is better than
those before it is audited densely; where it is too near to an obstacle between the instants at
which distances are kept, those instants are added.
"""

from dataclasses import replace

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.domain.robot.steering import steering_of
from planning.refine.audit import length_of
from planning.refine.cars.drive_refiner import refine_drive
from planning.refine.curves.chart import FlatChart, chart_of
from planning.refine.model.penalty_qp import solver_name
from planning.refine.multi_start import solve_multi_start
from planning.refine.refine_problem import RefineProblem
from planning.refine.request import RefineRequest
from planning.world.world import World

# Least remaining time of a plan for the method "auto" to refine [s].
_AMPLE = 0.5
# Share of the remaining time that this stage may use.
_SHARE = 0.35


def refine(
    world: World, request: RefineRequest, deadline: Deadline
) -> tuple[JointSpline | None, RefineReport]:
    """Return a curve from the path's start to its goal that should take less time, if there is one.

    Not promised: that the curve is free between the audited samples, nor that the retimer makes it
    quicker than the path. The caller times and certifies both.

    Args:
        world: The scene, loaded.
        request: Path, limits, margins and constraints.
        deadline: Of the whole plan; a share of what remains is used.

    Returns:
        The curve (arcs and lines of a car), or None if the path is to be used; and a report with
            the reason.
    """
    path = request.path
    report = RefineReport(request.options.method, improved=False, length_before=path.length)
    share = deadline.share(_SHARE)
    refusal = _refusal(request, share)
    if refusal:
        return None, replace(report, reason=refusal)
    if steering_of(path.group):
        return refine_drive(world, request, share, report)
    return _refine_curve(world, request, share, report)


def _refine_curve(
    world: World, request: RefineRequest, share: Deadline, report: RefineReport
) -> tuple[JointSpline | None, RefineReport]:
    """Return a curve near a path of joints without steering."""
    task = RefineProblem.of(world, request, share)
    report = replace(report, solver=solver_name(), lower_bound=task.least)
    if not task.is_held:
        return None, replace(report, reason="gravity is more than a joint can hold at an end")
    found = solve_multi_start(world, task)
    best = found.best
    report = replace(report, rounds=found.steps, duration_before=task.duration_of(found.guess))
    if best is not None and found.steps == 0 and len(task.waypoints) == 2:
        return None, replace(report, reason="nothing is quicker than the straight path")
    if best is None:
        return None, replace(report, reason=found.reason)
    curve = found.task.curve_of(best)
    return curve, replace(
        report, improved=True, length_after=length_of(curve), duration_after=best.duration
    )


def _refusal(request: RefineRequest, share: Deadline) -> str:
    """Return why no refinement begins, or ""."""
    if request.options.method == "none":
        return "not asked for"
    unfit = _unfit(request.path)
    if unfit:
        return unfit
    if request.options.method == "auto" and share.remaining < _SHARE * _AMPLE:
        share.on_cut()
        return f"less than {_AMPLE:g} s were left"
    return "no time was left" if share.is_over else ""


def _unfit(path: JointPath) -> str:
    """Return why a path cannot be refined, or ""."""
    chart, num_cars = chart_of(path), len(steering_of(path.group))
    if num_cars > 1 or (num_cars and not isinstance(chart, FlatChart)):
        return "several cars, or a car with a joint that floats, are left alone"
    if len(chart.waypoints) < 2:
        return "the path does not move"
    return ""
