"""stop_motion() and splice_motion(): leave a running motion, for a stand or for another motion."""

from dataclasses import dataclass

import numpy as np

from planning.certify.certifier import CertifyRequest, certify
from planning.certify.refusal import failed_checks, not_certified
from planning.domain.certificate import Certificate
from planning.domain.curve import TimedTrajectory
from planning.domain.deadline import Deadline
from planning.domain.motion_state import MotionState
from planning.domain.report import CertifyReport
from planning.domain.value import Value
from planning.errors import RetimingFailed
from planning.retime.state_to_state import to_rest, to_state
from planning.world.world import World

# Instants of a new motion at which it may be joined.
_JOINTS = 12


@dataclass(frozen=True, eq=False)
class ProvenMotion(Value):
    """A motion that begins as another goes on, and its proof.

    Attributes:
        trajectory: From the instant on; it may begin moving.
        certificate: The proof, jerk and continuity of acceleration included.
        certify: What it took.
    """

    trajectory: TimedTrajectory
    certificate: Certificate
    certify: CertifyReport


def stop_motion(
    world: World,
    group: str,
    running: TimedTrajectory,
    time: float,
    *,
    deadline: Deadline,
    margin: float | None = None,
) -> ProvenMotion:
    """Return the quickest stop from an instant of a motion, under jerk limits.

    Every joint brakes by itself, so the stop leaves the path; it is proven like any motion.

    Args:
        world: The scene, loaded.
        group: What moves.
        running: What it does.
        time: When it shall begin to stop [s].
        deadline: When to give up.
        margin: Distance to keep [m]; None for the scene's.

    Raises:
        UnknownName: There is no such group.
        RetimingFailed: A joint is planar or floating, or there is no such stop.
        NotCertified: The stop cannot be proven; evidence has the failed checks.
        DeadlineExceeded: Time ran out.
        Canceled: Somebody asked for the end.
    """
    joints = world.group(group)
    made = to_rest(joints.joints, world.limits(joints), MotionState.of(running, time))
    return _first_proven(world, group, [made], margin, deadline)


def splice_motion(
    world: World,
    group: str,
    running: TimedTrajectory,
    time: float,
    onto: TimedTrajectory,
    *,
    deadline: Deadline,
) -> ProvenMotion:
    """Return the quickest proven way from an instant of a motion into another one, without a rest.

    The other motion is joined at one of some instants, in the state that it has there; the sooner
    all is over the better.

    Args:
        world: The scene, loaded.
        group: What moves.
        running: What it does.
        time: When it leaves that [s].
        onto: What it shall go over to.
        deadline: When to give up.

    Raises:
        UnknownName: There is no such group.
        RetimingFailed: A joint is planar or floating, or no state of the other motion is reached.
        NotCertified: No way over can be proven; evidence has the failed checks of the last.
        DeadlineExceeded: Time ran out.
        Canceled: Somebody asked for the end.
    """
    joints = world.group(group)
    limits, state = world.limits(joints), MotionState.of(running, time)
    made: list[TimedTrajectory] = []
    failure: RetimingFailed | None = None
    for instant in np.linspace(0.0, onto.duration, _JOINTS)[:-1]:
        try:
            over = to_state(joints.joints, limits, state, MotionState.of(onto, float(instant)))
        except RetimingFailed as fault:
            failure = fault
            continue
        made.append(TimedTrajectory.joined([over, onto.after(float(instant))]))
    if not made and failure is not None:
        raise failure
    made.sort(key=lambda motion: motion.duration)
    return _first_proven(world, group, made, None, deadline)


def _first_proven(
    world: World,
    group: str,
    made: list[TimedTrajectory],
    margin: float | None,
    deadline: Deadline,
) -> ProvenMotion:
    """Return the first motion that is proven to keep everything from its first instant on."""
    joints = world.group(group)
    refused: list[str] = []
    failed: Certificate | None = None
    for motion in made:
        request = CertifyRequest(
            group=joints,
            trajectory=motion,
            state=world.state,
            start=motion.start,
            goals=motion.end[None],
            limits=world.limits(joints),
            margins=world.margins(margin),
            jerk=True,
            is_under_way=True,
        )
        certificate, report = certify(world.drake, request, deadline)
        if certificate.proven:
            return ProvenMotion(motion, certificate, report)
        failed = certificate
        refused.append(f"in {motion.duration:.3f} s: {failed_checks(certificate)}")
    raise not_certified(failed, refused)
