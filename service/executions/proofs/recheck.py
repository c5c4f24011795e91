"""A motion that is carried out, proven again from where the robot is as its scene was edited."""

import time
from collections.abc import Sequence

from planning import Deadline, World, certify_rest, certify_trajectory, holding_world
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from service.executions.proofs.beside_proof import BESIDE, first_in_the_way
from service.executions.proofs.demands import kept_by
from service.executions.proofs.tasks import RECHECK, GroupMotion, Recheck, RecheckWork
from service.executions.proofs.together_proof import (
    certificate_of,
    failed_besides_clearance,
    largest_margin,
)
from service.executions.tasks import Block
from service.jobs.context import TaskContext
from service.scenes.world_cache import borrow_world

# A robot moves meanwhile: what is not decided by then counts as blocked [s].
_ALLOWED = 1.0
_CLEARANCE = "clearance"


@RECHECK.runs
def recheck(work: RecheckWork, context: TaskContext) -> Recheck:
    """Say where a motion is blocked, if it does not hold any more, on the way on and back.

    Raises:
        DeadlineExceeded: Time ran out before the verdict.
        InputError: What the motion keeps names something that is not in this scene any more.
    """
    trajectory = work.trajectory.to_domain()
    since = min(work.since, trajectory.duration)
    with borrow_world(work) as borrowed:
        world = _holding(work, borrowed)
        # What loads is not what decides: only that is bounded.
        deadline = Deadline.after(_ALLOWED, time.monotonic, context.is_canceled)
        margin = largest_margin(world, work.margins)
        rest = certify_rest(world, work.group, trajectory, since, deadline=deadline, margin=margin)
        back = certify_rest(
            world,
            work.group,
            trajectory.reverse,
            trajectory.duration - since,
            deadline=deadline,
            margin=margin,
        )
        behind = None if back.proven else trajectory.duration - back.proven_until
        if not rest.proven:
            block = _block(work, trajectory, _CLEARANCE, rest.pair, rest.proven_until)
            return Recheck(block=block, behind=behind)
        certificates = _certificates(work, world, trajectory, deadline)
        beside = _beside(work, world, trajectory, deadline)
    # The way back is told apart. An edit that breaks a constraint, or a limit of a frame, does so
    # wherever the robot is.
    failed = [check for each in certificates for check in failed_besides_clearance(each)]
    if failed:
        at = max(since, failed[0].time)
        return Recheck(block=_block(work, trajectory, failed[0].name, (), at), behind=since)
    return Recheck(block=beside, behind=since if beside else behind)


def _holding(work: RecheckWork, world: World) -> World:
    """Return the world that the motion is proven in: fingers may come near what they close on."""
    if work.gripper is None:
        return world
    tools = world.group(work.group).tool_frames
    return holding_world(world, work.gripper.attached(tools[0] if tools else ""))


def _beside(
    work: RecheckWork, world: World, trajectory: TimedTrajectory, deadline: Deadline
) -> Block | None:
    """Say where another execution is in the way, if one is."""
    motion = GroupMotion(
        execution="", group=work.group, trajectory=work.trajectory, margins=work.margins
    )
    found = first_in_the_way(world, motion, work.others, deadline)
    if found is None:
        return None
    # Where both may meet is not where they would first: nothing is proven from here on.
    block = _block(work, trajectory, BESIDE, found.check.pair, work.since)
    return block.model_copy(update={"execution": found.execution})


def _certificates(
    work: RecheckWork, world: World, trajectory: TimedTrajectory, deadline: Deadline
) -> list[Certificate]:
    """Return what is certified of the motion, or of each of those that it is made of."""
    if work.members:
        return [
            certificate_of(world, member, member.trajectory.to_domain(), deadline)
            for member in work.members
        ]
    if work.gripper is not None:
        certificate, _ = certify_trajectory(world, work.group, trajectory, deadline=deadline)
        return [certificate]
    group, demands = kept_by(work.planned, work.own)
    certificate, _ = certify_trajectory(world, group, trajectory, deadline=deadline, **demands)
    return [certificate]


def _block(
    work: RecheckWork, trajectory: TimedTrajectory, check: str, pair: Sequence[str], at: float
) -> Block:
    fraction = trajectory.path_fraction(min(at, trajectory.duration))
    return Block(check=check, pair=list(pair), time=at, fraction=fraction, revision=work.revision)
