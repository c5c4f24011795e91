"""Proofs of the motions of several plans as one motion, with delays that are given or found.

Clearance, and the scene's limits at full scale, are those of the combined motion: each plan's own
certificate took the other robots for obstacles that stand, where a delay may have them pass. What a
plan was asked to keep besides, its motion keeps by itself.
"""

import time
from collections.abc import Sequence

from planning import Deadline, GroupMotion, World, certify_trajectory, schedule_motions
from planning.api.combine_motions import combine_motions
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate, Check
from service.executions.proofs.proof import refusal
from service.executions.proofs.tasks import PROVE_TOGETHER, ProvenMotion, TogetherWork
from service.executions.tasks import MemberMotion
from service.jobs.context import TaskContext
from service.plans.models.trajectory import Polynomial
from service.scenes.world_cache import borrow_world

# As `POST /trajectories/schedule` takes by default [s].
_ALLOWED = 10.0
_CLEARANCE = "clearance"


@PROVE_TOGETHER.runs
def prove_together(work: TogetherWork, context: TaskContext) -> ProvenMotion:
    """Return several motions as one, if that is proven.

    Raises:
        ScheduleNotFound: No delays keep the motions apart.
        NotCertified: It is not proven; evidence as of `certify_again`.
        DeadlineExceeded: Time ran out before the verdict.
        InputError: What a plan names is not in this scene any more.
    """
    deadline = Deadline.after(_ALLOWED, time.monotonic, context.is_canceled)
    motions = [
        GroupMotion(member.planned.group, member.trajectory.to_domain()) for member in work.members
    ]
    with borrow_world(work) as world:
        margin = largest_margin(world, [member.planned.margin for member in work.members])
        if work.delays is None:
            schedule = schedule_motions(world, motions, deadline=deadline, margin=margin)
            motion, certificate = schedule.motion, schedule.certificate
            delays = list(schedule.delays)
        else:
            delays = work.delays
            begun = [
                GroupMotion(one.group, one.trajectory, begin)
                for one, begin in zip(motions, delays, strict=True)
            ]
            motion = combine_motions(world, begun)
            certificate, _ = certify_trajectory(
                world, motion.group, motion.trajectory, deadline=deadline, margin=margin
            )
        if not certificate.proven:
            raise refusal(certificate, motion.trajectory)
        for member in work.members:
            alone = member.trajectory.to_domain()
            own = certificate_of(world, member, alone, deadline)
            if failed_besides_clearance(own):
                raise refusal(own, alone, failed_besides_clearance(own))
    return ProvenMotion(
        trajectory=Polynomial.from_domain(motion.trajectory),
        start=motion.trajectory.start.tolist(),
        min_clearance=certificate.min_clearance,
        delays=delays,
    )


def certificate_of(
    world: World, member: MemberMotion, trajectory: TimedTrajectory, deadline: Deadline
) -> Certificate:
    """Return the certificate of one of the motions by itself, by what its plan was asked for."""
    problem = member.planned.to_domain()
    certificate, _ = certify_trajectory(
        world,
        problem.group,
        trajectory,
        deadline=deadline,
        options=problem.retime,
        margin=problem.margin,
        constraints=problem.constraints,
    )
    return certificate


def failed_besides_clearance(certificate: Certificate) -> tuple[Check, ...]:
    """Return the checks that failed, but for clearance."""
    return tuple(check for check in certificate.failed if check.name != _CLEARANCE)


def largest_margin(world: World, margins: Sequence[float | None]) -> float | None:
    """Return the largest of some margins, None for that of the scene [m]."""
    asked = [margin for margin in margins if margin is not None]
    if not asked:
        return None
    if None in margins:
        asked.append(world.scene.margin)
    return max(asked)
