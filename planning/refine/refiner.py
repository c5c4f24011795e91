"""refine(): a smooth, quick and free curve near a path, or none and the reason why.

Constraint generation: distances are demanded at a few instants, the solution is audited densely,
the violated instants are added, and it is solved again from there.
"""

from collections.abc import Iterator
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
from planning.refine.buffers import Buffers
from planning.refine.fit import fit_control_points, spline_of, unwrapped
from planning.refine.power_basis import joint_spline
from planning.refine.program import SOLVER, CurveProgram, Solution
from planning.world.margins import PairMargins
from planning.world.world import World

# Iterations, not seconds, decide when to give up, so that the same request gives the same bytes.
_MAX_ROUNDS = 8
# Of the time that is left, what this stage may take.
_SHARE = 0.35
_FIRST_INSTANTS = np.linspace(0.0, 1.0, 27)[1:-1]
# A free curve that became quicker by less than this share is quick enough.
_WORTHWHILE = 0.02


@dataclass(frozen=True, eq=False)
class RefineRequest(Value):
    """What to refine.

    Attributes:
        path: Free, at the search's resolution.
        limits: Scaled as they will be for the retimer.
        margins: Distances to keep.
        options: Whether to refine at all.
        jerk: Whether the retimer will bound jerk, so that it counts here too.
    """

    path: JointPath
    limits: JointLimits
    margins: PairMargins
    options: RefineOptions
    jerk: bool = False


@dataclass(frozen=True)
class _Round:
    """One solution, converted and audited."""

    curve: JointSpline
    solution: Solution
    violated: np.ndarray


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
    path, limits = request.path, request.limits
    report = RefineReport(request.options.method, improved=False, length_before=path.length)
    waypoints = path.waypoints
    if request.options.method == "none":
        return None, replace(report, reason="not asked for")
    if not Manifold(path.group.joints).is_flat:
        reason = (
            "joint-space trajectory optimisation needs R^n coordinates; floating joints have none"
        )
        return None, replace(report, reason=reason)
    waypoints = unwrapped(path)
    if len(waypoints) < 2:  # noqa: PLR2004
        return None, replace(report, reason="the path does not move")
    share = deadline.share(_SHARE)
    if share.is_over:
        return None, replace(report, reason="no time was left")
    guess = fit_control_points(waypoints, limits.per_coordinate(limits.velocity))
    guess[1:-1] = np.clip(guess[1:-1], limits.lower, limits.upper)
    ends = world.embed(path.group, waypoints[[0, -1]])
    buffers = Buffers.between(world, request.margins, ends)
    program = CurveProgram(world, path.group, limits, buffers, guess, jerk=request.jerk)
    auditor = Auditor(world, path.group, buffers)
    report = replace(report, solver=SOLVER, duration_before=program.guessed_duration)
    return _best(program, auditor, request, share, report)


def _best(
    program: CurveProgram,
    auditor: Auditor,
    request: RefineRequest,
    share: Deadline,
    report: RefineReport,
) -> tuple[JointSpline | None, RefineReport]:
    """Return the quickest free curve of all rounds."""
    best: _Round | None = None
    rounds, reason = 0, "no time was left"
    try:
        for found in _rounds(program, auditor, request, share):
            rounds += 1
            reason = _refusal(found, program.guessed_duration, request.limits)
            if reason:
                continue
            before = program.guessed_duration if best is None else best.solution.duration
            gained = 1 - found.solution.duration / before
            if gained > 0:
                best = found
            if found.solution.converged or gained < _WORTHWHILE:
                break
    except RuntimeError as fault:  # Drake's word for a constraint that has no value
        reason = f"the solver stopped: {fault}"
    if best is None:
        return None, replace(report, rounds=rounds, reason=reason)
    return best.curve, replace(
        report,
        improved=True,
        rounds=rounds,
        length_after=length_of(best.curve),
        duration_after=best.solution.duration,
    )


def _rounds(
    program: CurveProgram, auditor: Auditor, request: RefineRequest, share: Deadline
) -> Iterator[_Round]:
    """Solve, audit and add the violated instants, until there are no rounds or no time left."""
    added = _FIRST_INSTANTS
    for _ in range(_MAX_ROUNDS):
        if share.is_over:
            return
        program.keep_distance_at(added)
        solution = program.solve(share.remaining)
        if solution.cut_short:
            return
        joints = request.path.group.joints
        curve = joint_spline(joints, spline_of(solution.control_points))
        added = auditor.violated(curve)
        yield _Round(curve, solution, added)


def _refusal(found: _Round, before: float, limits: JointLimits) -> str:
    """Return what is wrong with a curve, or ""."""
    if len(found.violated):
        where = ", ".join(f"{s:.3f}" for s in found.violated[:5])
        return f"the optimised curve is too near to something at s = {where}"
    if not within_limits(found.curve, limits):
        return "the optimised curve leaves the position limits"
    if found.solution.duration >= before:
        return f"the optimiser found nothing quicker than its guess of {before:.3f} s"
    return ""
