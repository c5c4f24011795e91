"""retime_path(): retiming and certification of a given path."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.certify.certifier import certify
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.goal import JointGoal
from planning.domain.report.certificate import Certificate
from planning.domain.report.stage_reports import CertifyReport, RetimeReport
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import CertifyOptions, RefineOptions, RetimeOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.value import Value
from planning.errors import ProblemInvalid
from planning.goals.start_validation import ROUNDING, limit_violations
from planning.pipeline.candidate_motions import candidates
from planning.pipeline.certification import Refusals, certify_request, first_certified
from planning.pipeline.motion import Motion
from planning.pipeline.segments import free_segment
from planning.pipeline.timing.candidate_timing import CandidateMotion
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.retime.limits.request_limits import path_limits
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.loading.positions import validate_positions
from planning.world.world import World


@dataclass(frozen=True, eq=False)
class RetimedPath(Value):
    """Certified motion along a given path.

    Attributes:
        path: The path, with angles unwrapped so that they do not jump by full turns.
        trajectory: The exact motion.
        certificate: Certificate of the motion.
        retime: Report of the retiming.
        certify: Report of the certification.
        cut_short: Stages cut short by the deadline: `explain`, or none.
    """

    path: JointPath
    trajectory: TimedTrajectory
    certificate: Certificate
    retime: RetimeReport
    certify: CertifyReport
    cut_short: tuple[str, ...] = ()


def retime_path(  # noqa: PLR0913  (all inputs of a request)
    world: World,
    group: str,
    waypoints: Any,
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    margin: float | None = None,
    constraints: tuple[PathConstraint, ...] = (),
    certify_options: CertifyOptions | None = None,
) -> RetimedPath:
    """Return the quickest certified motion along waypoints.

    Corners are rounded by at most 0.1 in joint-space length. If no motion with rounded corners is
    certified, the motion follows the path itself and rests at the corners.

    Args:
        world: Loaded scene.
        group: `robot` or `robot::group`.
        waypoints: The group's q, one per row, shape (n, nq), n >= 2; joined by geodesics.
        deadline: Time limit.
        options: Options of the retiming; None for the defaults.
        margin: Required distance of bodies [m]; None for the scene's.
        constraints: Path constraints; those relative to the start refer to the first waypoint.
        certify_options: Additional findings about the certified motion; None for none.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: There are fewer than two waypoints, one does not fit the group or is outside
            the joints' limits, or a limit or constraint is invalid.
        RetimingFailed: The path cannot be timed.
        NotCertified: No motion along the path is proven; evidence has the failed checks.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    joints = world.group(group)
    rows = [validate_positions(joints, q, f"waypoints.{i}") for i, q in enumerate(waypoints)]
    if len(rows) < 2:
        message = f"waypoints: at least 2 are needed, got {len(rows)}"
        raise ProblemInvalid(message, {"field": "waypoints", "got": len(rows)})
    path = JointPath(joints, np.array(rows)).continuous
    _validate_within_limits(world, path)
    validate_constraints(world, joints, constraints)
    timing = resolve_retiming(world, joints, options or RetimeOptions(), path.waypoints[0])
    problem = PlanningProblem(
        group,
        JointGoal(path.waypoints[-1:]),
        start=path.waypoints[0],
        refine=RefineOptions("none"),
        retime=timing,
        margin=margin,
        constraints=constraints,
    )
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures():
        return _first_certified(
            world,
            path,
            problem,
            certify_options or CertifyOptions(),
            deadline.with_on_expiry(watch.record_cut),
            watch,
        )


def _validate_within_limits(world: World, path: JointPath) -> None:
    """Raise if a waypoint is outside the position limits: no motion through it is certified.

    Raises:
        ProblemInvalid: One is; evidence has the joints and their bounds.
    """
    limits = world.limits(path.group)
    excess = np.maximum(limits.lower - path.waypoints, path.waypoints - limits.upper)
    for i in np.flatnonzero((excess > ROUNDING).any(axis=1))[:1]:
        outside = limit_violations(limits, path.group, path.waypoints[i])
        worst = max(outside, key=lambda entry: entry["violation"])
        message = (
            f"waypoints.{i}: {worst['joint']} = {worst['position']:.6g} is not in "
            f"[{worst['lower']:.6g}, {worst['upper']:.6g}], its limits"
        )
        raise ProblemInvalid(message, {"field": f"waypoints.{i}", "joints": outside})


def _first_certified(
    world: World,
    path: JointPath,
    problem: PlanningProblem,
    certify_options: CertifyOptions,
    deadline: Deadline,
    watch: Stopwatch,
) -> RetimedPath:
    joints, timing, margins = path.group, problem.retime, world.margins(problem.margin)
    limits_along_path = path_limits(world, joints, timing)
    all_candidates = candidates(
        world, path, problem, margins, deadline, watch, path_limits=limits_along_path
    )

    def certify_candidate(candidate: CandidateMotion) -> tuple[Certificate, CertifyReport]:
        request = replace(
            certify_request(world, joints, candidate.trajectory, timing, margins),
            start=path.waypoints[0],
            goals=path.waypoints[-1:],
            constraints=problem.constraints,
            options=certify_options,
        )
        with watch.stage("certify"):
            return certify(world.drake, request, deadline)

    named_candidates = ((candidate.name, candidate) for candidate in all_candidates)
    candidate, certificate, report = first_certified(
        named_candidates, certify_candidate, lambda timed: timed.trajectory, Refusals()
    )
    motion = Motion((free_segment(path, candidate),))
    if timing.explain:
        with watch.stage("explain"):
            motion = motion.with_explanation(
                world.limits(joints), timing, limits_along_path, deadline
            )
    return RetimedPath(path, motion.trajectory, certificate, motion.report, report, watch.cut_short)
