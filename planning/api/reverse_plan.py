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
from planning.pipeline.segment_lines import part_lines
from planning.pipeline.segments import empty_search_report
from planning.pipeline.timing_options import validate_timing
from planning.search.space_options import resolve_space
from planning.world.world import World

_KINDS = {"approach": "retreat", "retreat": "approach"}
# What the certificate has checks for, and the report of a timing its share.
_LIMITS = (
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
    deadline = deadline.cutting(watch.note_cut)
    group = resolve_space(world.group(problem.group), problem.search.spaces)
    back = trajectory.reverse
    turned = tuple(
        replace(
            part,
            kind=_KINDS.get(part.kind, part.kind),
            begin=trajectory.duration - part.end,
            end=trajectory.duration - part.begin,
        )
        for part in reversed(parts)
    )
    options = validate_timing(world, group, problem.retime, back.start)
    request = replace(
        certify_request(world, group, back, options, world.margins(problem.margin)),
        constraints=problem.constraints,
        lines=part_lines(world, group, problem, back, turned),
        options=problem.certify,
    )
    with watch.timing_failures():
        with watch.stage("certify"):
            certificate, report = certify(world.drake, request, deadline)
        if not certificate.proven:
            raise not_certified(certificate, ["the motion backwards"])
    way = JointPath(group, path.waypoints[::-1])
    stages = StageReports(
        GoalConfigurations(back.end[None], (0,), Funnel(1, 1, 1, 1, 1)),
        empty_search_report(way),
        RefineReport("none", improved=False, reason="the motion of another plan, backwards"),
        _timing(options.method, back, certificate, turned),
        report,
    )
    return MotionPlan(
        group=group,
        start=back.start,
        start_clipped=np.zeros(group.num_positions),
        goal_configuration=back.end,
        goal_index=0,
        path=way,
        trajectory=back,
        certificate=certificate,
        stages=stages,
        timings=watch.seconds,
        cut_short=watch.cut_short,
        parts=turned,
    )


def _timing(
    method: str, back: TimedTrajectory, certificate: Certificate, parts: Sequence[PlanPart]
) -> RetimeReport:
    """Return what the certificate says of the timing, which nobody chose anew."""
    binding: dict[str, str] = {}
    used: dict[str, float] = {}
    for check in certificate.checks:
        # Checks of frames and zones are named after them.
        kind, _, named = check.name.partition(" ")
        if kind in _LIMITS:
            share = check.value if check.unit == "1" else check.value / check.bound
            if share > used.get(kind, -1.0):
                binding[kind], used[kind] = named or check.where, share
    return RetimeReport(
        method=method,
        duration=back.duration,
        slowed=1.0,
        binding=binding,
        utilisation=used,
        stops=max(0, len(parts) - 1),
    )
