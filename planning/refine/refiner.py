"""refine(): trajectory optimization of a path: a better, free curve, or none and the reason.

Two methods do the work: convex steps (`convex_steps`) and Drake's kinematic trajectory optimization
(`drake/drake_refiner`). Here it is decided whether one begins, and how long it may take.
"""

from collections.abc import Mapping

from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.refine.convex_steps import ConvexSteps
from planning.refine.curves.chart import make_chart
from planning.refine.drake.drake_refiner import DrakeRefiner
from planning.refine.refine_method import Refined, Refiner
from planning.refine.request import RefineRequest
from planning.world.world import World

REFINERS: Mapping[str, Refiner] = {
    "auto": ConvexSteps(),
    "drake": DrakeRefiner(),
    "trajopt": ConvexSteps(),
}
# Least remaining time of a plan for the method "auto" to refine [s].
_MIN_REMAINING_TIME = 0.5
# Share of the remaining time that this stage may use.
_TIME_SHARE = 0.35


def refine(
    world: World, request: RefineRequest, deadline: Deadline
) -> tuple[Refined, RefineReport]:
    """Return a curve from the path's start to its goal that should cost less, if there is one.

    Not promised: that the curve is free between the audited samples, or that its motion is better
    than that along the path. The caller times and certifies both.

    Args:
        world: The scene, loaded.
        request: Path, limits, margins and constraints.
        deadline: Deadline of the whole plan; a share of the remaining time is used.

    Returns:
        The curve (arcs and lines of a car), with its own time if the method has one, or None if the
            path is to be used; and a report with the reason.
    """
    path, method = request.path, request.options.method
    stage_deadline = deadline.at_fraction(_TIME_SHARE)
    skip_reason = _skip_reason(request, stage_deadline)
    report = RefineReport(method, improved=False, length_before=path.length, reason=skip_reason)
    if skip_reason:
        return None, report
    return REFINERS[method].refine(world, request, stage_deadline, report)


def _skip_reason(request: RefineRequest, deadline: Deadline) -> str:
    """Return why no refinement begins, or ""."""
    method = request.options.method
    if method == "none":
        return "refine.method is none"
    unsupported_reason = REFINERS[method].unsupported_reason(request)
    if unsupported_reason:
        return unsupported_reason
    if len(make_chart(request.path).waypoints) < 2:
        return "the path has zero length"
    if method == "auto" and deadline.remaining < _TIME_SHARE * _MIN_REMAINING_TIME:
        deadline.on_expiry()
        return f"method auto: less than {_MIN_REMAINING_TIME:g} s of planning time remained"
    return "the deadline passed before refinement began" if deadline.is_over else ""
