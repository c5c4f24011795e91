"""reverse_plan(): the same motion from its end to its start, proven anew."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from planning.certify.certifier import certify
from planning.certify.failure import not_certified
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.goals.funnel import Funnel
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.report.certificate import Certificate
from planning.domain.report.motion_plan import MotionPlan, PlanPart, StageReports
from planning.domain.report.stage_reports import RefineReport, RetimeReport
from planning.domain.request.deadline import Deadline
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.stopwatch import Stopwatch
from planning.pipeline.certification import certify_request
from planning.pipeline.line_sections import line_sections
from planning.pipeline.segments import empty_search_report
from planning.pipeline.timing_options import resolve_retiming
from planning.search.space_options import resolve_space
from planning.world.world import World

_REVERSED_KINDS = {"approach": "retreat", "retreat": "approach"}
# What the certificate has checks for, and the report of a timing its share.
_TIMING_CHECKS = (
    "velocity",
    "acceleration",
    "jerk",
    "torque",
    "tool_speed",
    "tool_acceleration",
    "speed_zone",
)


def reverse_plan(
    world: World,
    problem: PlanningProblem,
    path: JointPath,
    trajectory: TimedTrajectory,
    parts: Sequence[PlanPart],
    deadline: Deadline,
) -> MotionPlan:
    """Return the motion of a plan backwards, as a plan of its own.

    It is held against the same limits, margins, lines, path constraints and steering, by the same
    scene as it is: what a robot holds, it holds on the way back. Constraints that speak of the
    start speak of the start of this motion. A car without reverse has no way back.

    Args:
        world: The scene, loaded.
        problem: What the motion solved.
        path: Its waypoints.
        trajectory: The motion.
        parts: What it is made of.
        deadline: When to give up.

    Raises:
        UnknownName: The scene has no such group.
        ProblemInvalid: The problem's cars or limits make no sense in this scene.
        NotCertified: The motion backwards cannot be proven; evidence has the failed checks.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    watch = Stopwatch(deadline.clock)
    deadline = deadline.with_on_expiry(watch.record_cut)
    group = resolve_space(world.group(problem.group), problem.search.spaces)
    reversed_motion = trajectory.reverse
    reversed_parts = tuple(
        replace(
            part,
            kind=_REVERSED_KINDS.get(part.kind, part.kind),
            begin=trajectory.duration - part.end,
            end=trajectory.duration - part.begin,
        )
        for part in reversed(parts)
    )
    options = resolve_retiming(world, group, problem.retime, reversed_motion.start)
    request = replace(
        certify_request(world, group, reversed_motion, options, world.margins(problem.margin)),
        constraints=problem.constraints,
        lines=line_sections(world, group, problem, reversed_motion, reversed_parts),
        options=problem.certify,
    )
    with watch.timing_failures():
        with watch.stage("certify"):
            certificate, report = certify(world.drake, request, deadline)
        if not certificate.proven:
            raise not_certified(certificate, ["the motion backwards"])
    reversed_path = JointPath(group, path.waypoints[::-1])
    stages = StageReports(
        GoalConfigurations(reversed_motion.end[None], (0,), Funnel(1, 1, 1, 1, 1)),
        empty_search_report(reversed_path),
        RefineReport("none", improved=False, reason="the motion of another plan, backwards"),
        _retime_report(options.method, reversed_motion, certificate, reversed_parts),
        report,
    )
    return MotionPlan(
        group=group,
        start=reversed_motion.start,
        start_clipped=np.zeros(group.num_positions),
        goal_configuration=reversed_motion.end,
        goal_index=0,
        path=reversed_path,
        trajectory=reversed_motion,
        certificate=certificate,
        stages=stages,
        timings=watch.seconds,
        cut_short=watch.cut_short,
        parts=reversed_parts,
    )


def _retime_report(
    method: str,
    reversed_motion: TimedTrajectory,
    certificate: Certificate,
    parts: Sequence[PlanPart],
) -> RetimeReport:
    """Return what the certificate says of the timing, which nobody chose anew."""
    binding: dict[str, str] = {}
    utilisation: dict[str, float] = {}
    for check in certificate.checks:
        # Checks of frames and zones are named after them.
        kind, _, limited_frame = check.name.partition(" ")
        if kind in _TIMING_CHECKS:
            ratio = check.value if check.unit == "1" else check.value / check.bound
            if ratio > utilisation.get(kind, -1.0):
                binding[kind], utilisation[kind] = limited_frame or check.where, ratio
    return RetimeReport(
        method=method,
        duration=reversed_motion.duration,
        slowed=1.0,
        binding=binding,
        utilisation=utilisation,
        stops=max(0, len(parts) - 1),
    )
