"""What is left of a motion that is carried out, proven again in its scene as that was edited."""

import time
from typing import Any

from planning import Deadline, RetimeOptions, World, certify_trajectory
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from service.executions.tasks import RECHECK, Block, Recheck, RecheckWork
from service.jobs.context import TaskContext
from service.scenes.world_cache import borrow_world
from service.trajectories.demands import demands_of, options_of

# A robot moves meanwhile: what is not decided by then counts as blocked [s].
_ALLOWED = 1.0
_CLEARANCE = "clearance"


@RECHECK.runs
def recheck(work: RecheckWork, context: TaskContext) -> Recheck:
    """Say where a motion is blocked, if what is left of it does not hold any more.

    Raises:
        DeadlineExceeded: Time ran out before the verdict.
        InputError: What the motion keeps names something that is not in this scene any more.
    """
    trajectory = work.trajectory.to_domain()
    deadline = Deadline.after(_ALLOWED, time.monotonic, context.is_canceled)
    with borrow_world(work) as world:
        group, demands = _demands(work)
        certificate, _ = certify_trajectory(world, group, trajectory, deadline=deadline, **demands)
        if certificate.proven:
            return Recheck(block=None)
        failed = [check for check in certificate.failed if check.name != _CLEARANCE]
        if failed:
            # An edit that breaks a constraint or a limit of a frame does so wherever the robot is.
            return _blocked(work, trajectory, failed[0].name, [], max(work.since, failed[0].time))
        return _on_the_rest(work, world, trajectory, deadline)


def _on_the_rest(
    work: RecheckWork, world: World, trajectory: TimedTrajectory, deadline: Deadline
) -> Recheck:
    """Return where the clearance of what is left fails, if it does."""
    group, demands = _demands(work)
    if work.since >= trajectory.duration:
        return Recheck(block=None)
    rest = trajectory.after(work.since) if work.since > 0 else trajectory
    certificate, _ = certify_trajectory(world, group, rest, deadline=deadline, **demands)
    if all(check.passed for check in certificate.checks if check.name == _CLEARANCE):
        return Recheck(block=None)
    pair = _pair(certificate)
    return _blocked(work, trajectory, _CLEARANCE, pair, work.since + certificate.proven_until)


def _demands(work: RecheckWork) -> tuple[str, dict[str, Any]]:
    """Return the group that moves, and what its motion keeps."""
    if work.own is not None:
        options = options_of(work.own, limit_jerk=work.own.limit_jerk)
        return work.own.group, dict(demands_of(work.own, options))
    if work.planned is None:
        message = "a motion is a plan's or the client's own"
        raise AssertionError(message)
    problem = work.planned.to_domain()
    options: RetimeOptions = problem.retime
    kept = {"options": options, "margin": problem.margin, "constraints": problem.constraints}
    return problem.group, kept


def _pair(certificate: Certificate) -> list[str]:
    first = certificate.first_unproven
    return list(certificate.pair if first is None else first.bodies)


def _blocked(
    work: RecheckWork, trajectory: TimedTrajectory, check: str, pair: list[str], at: float
) -> Recheck:
    fraction = trajectory.path_fraction(min(at, trajectory.duration))
    block = Block(check=check, pair=pair, time=at, fraction=fraction, revision=work.revision)
    return Recheck(block=block)
