"""refine(): a smooth, quick and free curve near a path, or none and the reason why.

Sequential convex programming in a trust region (`curve_model`, `descent`). Every curve that is
better than those before it is audited densely; where it is too near to something between the
instants at which distances are demanded, those instants join them.
"""

from dataclasses import replace

from planning.domain.curve import JointSpline
from planning.domain.deadline import Deadline
from planning.domain.path import JointPath
from planning.domain.report import RefineReport
from planning.domain.steering import steering_of
from planning.refine.audit import length_of
from planning.refine.basis import centres
from planning.refine.chart import FlatChart, chart_of
from planning.refine.request import RefineRequest
from planning.refine.soft_rows import solver_name
from planning.refine.task import RefineTask
from planning.world.kernel_scene import kernel_scene_of
from planning.world.world import Array, World

# How closely the guess follows the path [rad or m]: nearer where the first led to nothing free.
_CLOSE = (0.15, 0.04)
# With less than this left of a plan's time, the automatic method leaves the path alone [s].
_AMPLE = 0.5
# Of the time that is left, what this stage may take.
_SHARE = 0.35
# Where the first descent ends farther above it than this, another way is tried as well.
_SATISFYING = 1.03


def refine(
    world: World, request: RefineRequest, deadline: Deadline
) -> tuple[JointSpline | None, RefineReport]:
    """Return a curve from the path's start to its goal that should take less time, if there is one.

    Not promised: that the curve is free between the audited samples, nor that the retimer makes
    it quicker than the path. The caller times and certifies both.

    Args:
        world: The scene, loaded.
        request: The path and what to keep.
        deadline: Of the whole plan; a share of what remains is used.

    Returns:
        The curve, or None for "go on with the path"; and a report that says why.
    """
    path = request.path
    report = RefineReport(request.options.method, improved=False, length_before=path.length)
    share = deadline.share(_SHARE)
    refusal = _refusal(world, request, share)
    if refusal:
        return None, replace(report, reason=refusal)
    task = RefineTask.of(world, request, share)
    report = replace(report, solver=solver_name(), lower_bound=task.least)
    if not task.is_held:
        return None, replace(report, reason="gravity is more than a joint can hold at an end")
    best, steps, reason = None, 0, ""
    guesses = [task.fitted(closeness) for closeness in _CLOSE]
    for guess in guesses:
        if best is None and not share.is_over:
            best, more, reason = task.descend(guess)
            steps += more
    if best is not None and best.worth > _SATISFYING * task.least and not share.is_over:
        other, more, _ = task.descend(_straightened(best.points))
        steps += more
        best = other if other is not None and other.worth < best.worth else best
    report = replace(report, rounds=steps, duration_before=task.duration_of(guesses[0]))
    if best is not None and steps == 0 and len(task.waypoints) == 2:
        return None, replace(report, reason="nothing is quicker than the straight path")
    if best is None:
        return None, replace(report, reason=reason)
    curve = task.curve_of(best)
    return curve, replace(
        report, improved=True, length_after=length_of(curve), duration_after=best.duration
    )


def _straightened(points: Array) -> Array:
    """Return control points halfway to the straight line between the ends.

    A descent stops on the side of obstacles where it began; from here others are as near.
    """
    straight = points[0] + centres(len(points))[:, None] * (points[-1] - points[0])
    return (points + straight) / 2


def _refusal(world: World, request: RefineRequest, share: Deadline) -> str:
    """Return why not to begin, or ""."""
    if request.options.method == "none":
        return "not asked for"
    unfit = _unfit(world, request.path)
    if unfit:
        return unfit
    if request.options.method == "auto" and share.remaining < _SHARE * _AMPLE:
        return f"less than {_AMPLE:g} s were left"
    return "no time was left" if share.is_over else ""


def _unfit(world: World, path: JointPath) -> str:
    """Return why a path must be left alone, or has no coordinates along it, or ""."""
    if steering_of(path.group):
        return "a car's path is left alone: a refined curve would slip sideways or turn too tightly"
    chart = chart_of(path)
    if len(chart.waypoints) < 2:
        return "the path does not move"
    if isinstance(chart, FlatChart):
        return ""
    if kernel_scene_of(world.drake) is None:
        return "without the native kernel there are no gradients for floating joints"
    if not chart.reaches:
        return "a floating joint turns too far for the coordinates of one tangent space"
    return ""
