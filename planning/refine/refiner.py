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
from planning.world.world import Array, World

# Iterations, not seconds, decide when to give up, so that the same request gives the same bytes.
_MAX_ROUNDS = 12
# After so many refused solutions, steps are bounded by a box that is crossed in this time [s].
_PATIENCE = 5
_FIRST_BOX = 0.3
_GROWTH = 4.0
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
    violated: Array
    refusal: str


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
    share = deadline.share(_SHARE)
    refusal = _refusal(request, share)
    if refusal:
        return None, replace(report, reason=refusal)
    waypoints = unwrapped(path)
    guess = fit_control_points(waypoints, limits.per_coordinate(limits.velocity))
    guess[1:-1] = np.clip(guess[1:-1], limits.lower, limits.upper)
    ends = world.embed(path.group, waypoints[[0, -1]])
    buffers = Buffers.between(world, request.margins, ends)
    program = CurveProgram(world, path.group, limits, buffers, guess, jerk=request.jerk)
    auditor = Auditor(world, path.group, buffers)
    report = replace(report, solver=SOLVER, duration_before=program.guessed_duration)
    return _best(program, auditor, request, share, report)


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
    return "no time was left" if share.is_over else ""


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
            reason = found.refusal
            if not reason and (best is None or found.solution.duration < best.solution.duration):
                best = found
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
    """Solve, audit and add the violated instants, until it is good, or rounds or time run out.

    Where that alone does not help (the solver has jumped through a thin wall and is pushed out
    on the wrong side), go back to the last curve that was free, or else to the guess, and take
    steps that are short enough; the box shrinks with every failure and grows with every success.
    """
    added, misses, box = _FIRST_INSTANTS, 0, np.inf
    anchor, duration = program.guess, program.guessed_duration
    for _ in range(_MAX_ROUNDS):
        if share.is_over:
            return
        program.keep_distance_at(added)
        solution = program.solve(share.remaining)
        if solution.cut_short:
            return
        found = _audited(auditor, request, solution, program.guessed_duration)
        added = found.violated
        yield found
        if len(added):
            misses += 1
            if misses >= _PATIENCE:
                box = min(box / 2, _FIRST_BOX)
                program.stay_near(anchor, box)
            continue
        gained = 1 - solution.duration / duration
        anchor, duration = solution.control_points, solution.duration
        if (box == np.inf and solution.converged) or gained < _WORTHWHILE:
            return
        if box < np.inf:
            box *= _GROWTH
            program.stay_near(anchor, box)


def _audited(auditor: Auditor, request: RefineRequest, solution: Solution, before: float) -> _Round:
    curve = joint_spline(request.path.group.joints, spline_of(solution.control_points))
    violated = auditor.violated(curve)
    refusal = ""
    if len(violated):
        where = ", ".join(f"{s:.3f}" for s in violated[:5])
        refusal = f"the optimised curve is too near to something at s = {where}"
    elif not within_limits(curve, request.limits):
        refusal = "the optimised curve leaves the position limits"
    elif solution.duration >= before:
        refusal = f"the optimiser found nothing quicker than its guess of {before:.3f} s"
    return _Round(curve, solution, violated, refusal)
