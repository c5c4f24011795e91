"""reverse_plan(): the motion of a plan from its end to its start, certified again."""

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
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.search.space_options import resolve_space
from planning.world.world import World

_REVERSED_KINDS = {"approach": "retreat", "retreat": "approach"}
# Checks of the certificate whose utilization is in the report of the retiming.
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
    """Return the reversed motion of a plan as a plan of its own.

    It is certified for the same limits, margins, lines, path constraints and steering, in the given
    state of the scene: attached objects stay attached. Constraints relative to the start refer to
    the start of the reversed motion. The motion of a car without reverse gear cannot be reversed.

    Args:
        world: Loaded scene.
        problem: Problem that the motion solves.
        path: Waypoints of the motion.
        trajectory: The motion.
        parts: Segments of the motion.
        deadline: Time limit.

    Raises:
        UnknownName: The scene has no such group.
        ProblemInvalid: The problem's cars or limits are invalid in this scene.
        NotCertified: The reversed motion is not proven; evidence has the failed checks.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
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
            raise not_certified(certificate, ["the reversed motion"], reversed_motion)
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
    """Return the report of the timing from the certificate, since no retiming took place."""
    binding: dict[str, str] = {}
    utilisation: dict[str, float] = {}
    for check in certificate.checks:
        # Names of checks of frames and zones contain the name of the frame or zone.
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
