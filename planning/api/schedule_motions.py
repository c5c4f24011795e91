"""schedule_motions(): the smallest delays at which several motions together are proven."""

from collections.abc import Sequence
from dataclasses import replace

from planning.api.certify_trajectory import certify_trajectory
from planning.api.combine_motions import combine_motions, groups_of
from planning.certify.failure import failed_checks, not_certified
from planning.domain.report.certificate import Certificate
from planning.domain.report.motion_schedule import MotionSchedule
from planning.domain.request.deadline import Deadline
from planning.domain.request.group_motion import GroupMotion
from planning.domain.request.options import RetimeOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.errors import ScheduleNotFound
from planning.pipeline.schedules.scheduler import Scheduler
from planning.world.world import World

# How often delays that the certificate refuses are left out and others tried.
_MAX_REFUSALS = 20


def schedule_motions(
    world: World,
    motions: Sequence[GroupMotion],
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    margin: float | None = None,
) -> MotionSchedule:
    """Return the smallest delays at which motions of several groups keep all margins together.

    The first motion waits least: its delay is the smallest with which there is a schedule, then
    the second motion's is, and so on (the lexicographic order). The schedule is proven: the
    certificate is about all motions as one.

    Not promised: the shortest duration of the whole, and the last hundredths of a second of a
    delay, as what is not certainly free counts as blocked. For the same reason a schedule may be
    missed in which two robots keep little more than their margin all along.

    Args:
        world: Loaded scene.
        motions: Motions of groups without a common joint, the most urgent first; `begin` of each is
            ignored.
        deadline: Time limit.
        options: Limits that the whole is certified under, as of `certify_trajectory`.
        margin: Required distance of bodies [m]; None for the scene's.

    Raises:
        ScheduleNotFound: No delays keep the margins; evidence: the groups, the pair of bodies, and
            when they meet.
        NotCertified: Whatever the delays, a motion violates limits, or a margin by itself.
        UnknownName: There is no such group.
        ProblemInvalid: There is no motion, two groups have a joint in common, or a motion is not
            one of its group's joints.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    groups = groups_of(world, motions)
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures(), watch.stage("schedule"):
        trajectories = [motion.trajectory for motion in motions]
        margins = world.margins(margin)
        scheduler = Scheduler(world, groups, trajectories, margins, deadline)
        refused: list[str] = []
        while True:
            found = scheduler.smallest()
            whole = combine_motions(
                world,
                [replace(m, begin=delay) for m, delay in zip(motions, found.delays, strict=True)],
            )
            certificate, report = certify_trajectory(
                world,
                whole.group,
                whole.trajectory,
                deadline=deadline,
                options=options,
                margin=margin,
            )
            if certificate.proven:
                waits = scheduler.waits(found)
                names, delays = scheduler.names, found.delays
                return MotionSchedule(names, delays, waits, whole, certificate, report)
            refused.append(f"delays {found.delays}: {failed_checks(certificate)}")
            is_clearance = {check.name for check in certificate.failed} == {"clearance"}
            if not (is_clearance and scheduler.block(found, certificate.pair)):
                raise not_certified(certificate, refused, whole.trajectory)
            if len(refused) >= _MAX_REFUSALS:
                raise _none_proven(scheduler.names, certificate, len(refused))


def _none_proven(groups: Sequence[str], certificate: Certificate, count: int) -> ScheduleNotFound:
    """Return the failure of motions of which the certificate refused one schedule after another."""
    pair = list(certificate.pair)
    message = f"none of the {count} smallest delays was proven; the last one failed at {pair}"
    evidence = {"groups": list(groups), "pair": pair, "time": certificate.time, "encounters": []}
    return ScheduleNotFound(message, evidence)
