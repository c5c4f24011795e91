"""retime_path(): time and prove a path that somebody else found."""

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
from planning.pipeline.candidates import Candidate, candidates
from planning.pipeline.certification import Refusals, certify_request, first_certified
from planning.pipeline.motion import Motion
from planning.pipeline.segments import free_segment
from planning.pipeline.timing_options import validate_timing
from planning.retime.limits.request_limits import path_limits
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.loading.positions import require_positions
from planning.world.world import World


@dataclass(frozen=True, eq=False)
class RetimedPath(Value):
    """A certified motion along a given path.

    Attributes:
        path: The path, with angles that never jump by whole turns.
        trajectory: The motion, exactly.
        certificate: The proof.
        retime: How it was timed.
        certify: How it was proven.
        cut_short: Stages that ended early because of the clock: `explain`, or none.
    """

    path: JointPath
    trajectory: TimedTrajectory
    certificate: Certificate
    retime: RetimeReport
    certify: CertifyReport
    cut_short: tuple[str, ...] = ()


def retime_path(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    waypoints: Any,
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    margin: float | None = None,
    constraints: tuple[PathConstraint, ...] = (),
    wanted: CertifyOptions | None = None,
) -> RetimedPath:
    """Return the quickest proven motion along waypoints.

    Corners are rounded as far as that can be proven, at most 0.1 in joint-space length; where they
    cannot be, the motion follows the very path and rests at them.

    Args:
        world: The scene, loaded.
        group: `robot` or `robot::group`.
        waypoints: The group's q, one per row, shape (n, nq), n >= 2; joined by geodesics.
        deadline: When to give up.
        options: How to time it.
        margin: Distance to keep [m]; None for the scene's.
        constraints: What it shall keep; what counts from the start counts from the first waypoint.
        wanted: What to find out about the motion besides its proof; None for nothing.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: There are fewer than two waypoints, one does not fit the group, or a limit
            or constraint makes no sense.
        RetimingFailed: The path cannot be timed.
        NotCertified: No motion along the path can be proven; evidence has the failed checks.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    joints = world.group(group)
    rows = [require_positions(joints, q, f"waypoints.{i}") for i, q in enumerate(waypoints)]
    if len(rows) < 2:
        message = f"waypoints: at least 2 are needed, got {len(rows)}"
        raise ProblemInvalid(message, {"field": "waypoints", "got": len(rows)})
    path = JointPath(joints, np.array(rows)).continuous
    validate_constraints(world, joints, constraints)
    timing = validate_timing(world, joints, options or RetimeOptions(), path.waypoints[0])
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
        return _first_proven(
            world,
            path,
            problem,
            wanted or CertifyOptions(),
            deadline.cutting(watch.note_cut),
            watch,
        )


def _first_proven(
    world: World,
    path: JointPath,
    problem: PlanningProblem,
    wanted: CertifyOptions,
    deadline: Deadline,
    watch: Stopwatch,
) -> RetimedPath:
    joints, timing, margins = path.group, problem.retime, world.margins(problem.margin)
    others = path_limits(world, joints, timing)
    made = candidates(world, path, problem, margins, deadline, watch, path_limits=others)

    def certified(candidate: Candidate) -> tuple[Certificate, CertifyReport]:
        request = replace(
            certify_request(world, joints, candidate.trajectory, timing, margins),
            start=path.waypoints[0],
            goals=path.waypoints[-1:],
            constraints=problem.constraints,
            options=wanted,
        )
        with watch.stage("certify"):
            return certify(world.drake, request, deadline)

    named = ((candidate.name, candidate) for candidate in made)
    candidate, certificate, report = first_certified(named, certified, Refusals())
    motion = Motion((free_segment(path, candidate),))
    if timing.explain:
        with watch.stage("explain"):
            motion = motion.explained(world.limits(joints), timing, others, deadline)
    timed = motion.trajectory, certificate, motion.report, report
    return RetimedPath(path, *timed, watch.cut_short)
