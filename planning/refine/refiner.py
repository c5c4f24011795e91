"""refine(): a smooth, quick and free curve near a path, or none and the reason why.

Sequential convex programming in a trust region (`curve_model`, `descent`). Every curve that is
better than those before it is audited densely; where it is too near to something between the
instants at which distances are demanded, those instants join them.
"""

from dataclasses import dataclass, replace

import numpy as np

from planning.domain.curve import JointSpline
from planning.domain.deadline import Deadline
from planning.domain.joints import JointLimits
from planning.domain.manifold import Manifold
from planning.domain.options import RefineOptions
from planning.domain.path import JointPath
from planning.domain.report import RefineReport
from planning.domain.value import Value
from planning.refine.audit import Auditor, length_of, within_limits
from planning.refine.basis import centres, spline_of
from planning.refine.buffers import Buffers
from planning.refine.curve_model import CurveModel, Look
from planning.refine.descent import Descent
from planning.refine.fit import fit_control_points, unwrapped
from planning.refine.nearness import Nearness, nearness_of
from planning.refine.pace import Bounds, Rates, duration_of, fastest_pace, grid_of
from planning.refine.power_basis import joint_spline
from planning.refine.ruled_nearness import RuledNearness, unknown_rules
from planning.refine.soft_rows import solver_name
from planning.world.margins import PairMargins
from planning.world.rules.path_rules import PathRules
from planning.world.world import Array, World

# Iterations, not seconds, decide when to give up, so that the same request gives the same bytes.
_MAX_STEPS = 25
# How closely the guess follows the path [rad or m]: nearer where the first led to nothing free.
_CLOSE = (0.15, 0.04)
# With less than this left of a plan's time, the automatic method leaves the path alone [s].
_AMPLE = 0.5
# Of the time that is left, what this stage may take.
_SHARE = 0.35
# The distance at which instants are looked at (joint-space length), and how many of them.
_APART = 0.045
_FEWEST, _MOST = 60, 200
# Nothing is to be gained from a motion that is this near to the least possible duration.
_OPTIMAL = 1.002
# Where the first descent ends farther above it than this, another way is tried as well.
_SATISFYING = 1.03


@dataclass(frozen=True, eq=False)
class RefineRequest(Value):
    """What to refine.

    Attributes:
        path: Free, at the search's resolution.
        limits: Scaled as they will be for the retimer.
        margins: Distances to keep.
        options: Whether to refine at all.
        jerk: Whether the retimer will bound jerk, so that it counts here too.
        rules: Path constraints, or None. Boxes and cones count as distances do, locked joints and
            tighter limits as limits; a path under others is left alone.
    """

    path: JointPath
    limits: JointLimits
    margins: PairMargins
    options: RefineOptions
    jerk: bool = False
    rules: PathRules | None = None


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
    refusal = _refusal(request, share)
    if refusal:
        return None, replace(report, reason=refusal)
    task = _Task.of(world, request, share)
    report = replace(report, solver=solver_name(), lower_bound=task.least)
    best, steps, reason = None, 0, ""
    guesses = [task.fitted(closeness) for closeness in _CLOSE]
    for guess in guesses:
        if best is None and not share.is_over:
            best, more, reason = task.descend(guess)
            steps += more
    if best is not None and best.duration > _SATISFYING * task.least and not share.is_over:
        other, more, _ = task.descend(_straightened(best.points))
        steps += more
        best = other if other is not None and other.duration < best.duration else best
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


def _refusal(request: RefineRequest, share: Deadline) -> str:
    """Return why not to begin, or ""."""
    if request.options.method == "none":
        return "not asked for"
    if not Manifold(request.path.group.joints).is_flat:
        return (
            "joint-space trajectory optimisation needs R^n coordinates; floating joints have none"
        )
    if len(unwrapped(request.path)) < 2:
        return "the path does not move"
    unknown = () if request.rules is None else unknown_rules(request.rules)
    if unknown:
        return f"it does not know {', '.join(unknown)}"
    if request.options.method == "auto" and share.remaining < _SHARE * _AMPLE:
        return f"less than {_AMPLE:g} s were left"
    return "no time was left" if share.is_over else ""


@dataclass(frozen=True)
class _Task:
    """What every attempt needs.

    Attributes:
        waypoints: Of the path, without jumps by whole turns.
        limits: The request's, as tight as its rules make them.
        least: The duration that no motion beats [s].
    """

    request: RefineRequest
    share: Deadline
    waypoints: Array
    limits: JointLimits
    bounds: Bounds
    least: float
    nearness: Nearness
    auditor: Auditor

    @classmethod
    def of(cls, world: World, request: RefineRequest, share: Deadline) -> "_Task":
        """Prepare."""
        group, rules, limits = request.path.group, request.rules, request.limits
        waypoints = unwrapped(request.path)
        ends = world.embed(group, waypoints[[0, -1]])
        buffers = Buffers.between(world, request.margins, ends)
        bounds = Bounds.of(limits, jerk=request.jerk)
        nearness = nearness_of(world, group, buffers)
        return cls(
            request,
            share,
            waypoints,
            limits if rules is None else rules.fixing(limits),
            bounds,
            bounds.least_duration(waypoints[-1] - waypoints[0]),
            nearness if rules is None else RuledNearness(nearness, rules),
            Auditor(world, group, buffers, rules),
        )

    def curve_of(self, seen: Look) -> JointSpline:
        """Return a curve in the form in which it goes on."""
        return joint_spline(self.request.path.group.joints, spline_of(seen.points))

    def fitted(self, closeness: float) -> Array:
        """Return the control points of a curve near the path."""
        limits = self.limits
        guess = fit_control_points(self.waypoints, self.bounds.velocity, closeness)
        guess[1:-1] = np.clip(guess[1:-1], limits.lower, limits.upper)
        return guess

    def duration_of(self, points: Array) -> float:
        """Return what a curve takes [s], free or not."""
        grid = grid_of(len(points))
        return duration_of(grid, fastest_pace(grid, Rates.of(grid, points, self.bounds)))

    def descend(self, guess: Array) -> tuple[Look | None, int, str]:
        """Return the quickest free curve that a descent finds, or None.

        And how many steps it took, and why the last curve was refused.
        """
        length = float(np.linalg.norm(np.diff(self.waypoints, axis=0), axis=1).sum())
        count = int(np.clip(length / _APART, _FEWEST, _MOST))
        instants = np.linspace(0.0, 1.0, count + 2)[1:-1]
        model = CurveModel(self.nearness, self.limits, self.bounds, len(guess), instants)
        descent = Descent(model, guess)
        best: Look | None = None
        reason = "no time was left"
        for seen in descent.run(_MAX_STEPS):
            if best is None or seen.duration < best.duration:
                reason, violated = self._refused(seen)
                if not reason:
                    best = seen
                if len(violated):
                    descent.keep_distance_at(violated, best)
            if self.share.is_over or (best is not None and best.duration < _OPTIMAL * self.least):
                break
        return best, descent.num_steps, reason

    def _refused(self, seen: Look) -> tuple[str, Array]:
        """Return what is wrong with a curve, or "", and the instants where it is too near."""
        curve = self.curve_of(seen)
        violated = self.auditor.violated(curve)
        if len(violated):
            where = ", ".join(f"{s:.3f}" for s in violated[:5])
            what = "is too near to something"
            what += "" if self.request.rules is None else " or breaks a path constraint"
            return f"the optimised curve {what} at s = {where}", violated
        if not within_limits(curve, self.limits):
            return "the optimised curve leaves the position limits", violated
        return "", violated
