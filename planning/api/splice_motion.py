"""stop_motion() and splice_motion(): leave a running motion, for a stand or for another motion."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from planning.api.certify_trajectory import validate_joints
from planning.certify.certifier import certify
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.motion_state import MotionState
from planning.domain.report.certificate import Certificate
from planning.domain.report.stage_reports import CertifyReport
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import AccelerationBounds
from planning.domain.request.options import RetimeOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.value import Value
from planning.errors import ProblemInvalid, RetimingFailed
from planning.pipeline.certification import Refusals, certify_request, first_certified
from planning.pipeline.timing_options import resolve_retiming
from planning.retime.jerk.state_to_state import to_rest, to_state
from planning.retime.jerk.stop_along_path import stops_along
from planning.retime.limits.request_limits import path_limits
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.world import World

# Instants of a new motion at which it may be joined.
_NUM_JOIN_TIMES = 12


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


@dataclass(frozen=True)
class _RunningMotion:
    """What is left, and what holds on whatever way leads from it."""

    world: World
    group: JointGroup
    running: TimedTrajectory
    options: RetimeOptions
    constraints: tuple[PathConstraint, ...]
    margin: float | None

    @property
    def limits(self) -> JointLimits:
        factors = self.options.velocity_scale, self.options.acceleration_scale
        return self.world.limits(self.group).scaled(*factors)

    @property
    def acceleration_bounds(self) -> AccelerationBounds:
        return self.options.acceleration_bounds

    def certify_first(
        self, motions: Iterable[TimedTrajectory], deadline: Deadline, *, has_jerk_limit: bool = True
    ) -> ProvenMotion:
        """Return the first motion that is proven to keep everything from its first instant on."""
        watch = Stopwatch(deadline.clock)
        margins = self.world.margins(self.margin)

        def certify_motion(motion: TimedTrajectory) -> tuple[Certificate, CertifyReport]:
            request = replace(
                certify_request(self.world, self.group, motion, self.options, margins),
                jerk=has_jerk_limit,
                constraints=self.constraints,
                origin=self.running.start,
            )
            with watch.stage("certify"):
                return certify(self.world.drake, request, deadline)

        with watch.timing_failures():
            timed = watch.each("retime", motions)
            named_motions = ((f"in {motion.duration:.3f} s", motion) for motion in timed)
            return ProvenMotion(*first_certified(named_motions, certify_motion, Refusals()))


def stop_motion(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    running: TimedTrajectory,
    time: float,
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    constraints: tuple[PathConstraint, ...] = (),
    margin: float | None = None,
    along_path: bool = False,
) -> ProvenMotion:
    """Return the quickest stop from an instant of a motion, under jerk limits.

    Every joint brakes by itself, so the stop leaves the path; it is proven like any motion, and
    held to what the motion was planned with only as far as that is told here. Along the path it is
    the motion itself, slowed down, as quickly as profiles of one form allow; at worst its end.

    Args:
        world: The scene, loaded.
        group: What moves.
        running: What it does.
        time: When it shall begin to stop [s].
        deadline: When to give up.
        options: Scales of the limits, and limits besides; the rest of them has no meaning here, but
            for a stop along the path: there `method` "toppra" lets accelerations jump, from the
            first instant on, and "ruckig", or no options, does not.
            What they and the constraints say of the start they say of where `running` begins.
        constraints: What it shall keep.
        margin: Distance to keep [m]; None for the scene's.
        along_path: Whether it shall stay on the path of `running`.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: `running` is of other joints or no motion, `time` is not within it, or a
            limit or constraint makes no sense.
        RetimingFailed: A joint is planar or floating, or there is no such stop; never along the
            path.
        NotCertified: The stop cannot be proven; evidence has the failed checks.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    running_motion = _make_running_motion(world, group, running, options, constraints, margin)
    _validate_time(running, time)
    if along_path:
        limits_along_path = path_limits(world, running_motion.group, running_motion.options)
        has_jerk_limit = running_motion.options.method == "ruckig"
        stops = stops_along(
            running, time, running_motion.limits, limits_along_path, deadline, jerk=has_jerk_limit
        )
        return running_motion.certify_first(stops, deadline, has_jerk_limit=has_jerk_limit)
    stop = to_rest(
        running.joints,
        running_motion.limits,
        MotionState.of(running, time),
        running_motion.acceleration_bounds,
    )
    return running_motion.certify_first([stop], deadline)


def splice_motion(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    running: TimedTrajectory,
    time: float,
    onto: TimedTrajectory,
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    constraints: tuple[PathConstraint, ...] = (),
    margin: float | None = None,
) -> ProvenMotion:
    """Return the quickest proven way from an instant of a motion into another one, without a rest.

    The other motion is joined at one of some instants, in the state that it has there; the sooner
    all is over the better. All of it, the rest of the other motion too, is held to what is told
    here.

    Args:
        world: The scene, loaded.
        group: What moves.
        running: What it does.
        time: When it leaves that [s].
        onto: What it shall go over to.
        deadline: When to give up.
        options: Scales of the limits, and limits besides; the rest of them has no meaning here.
            What they and the constraints say of the start they say of where `running` begins.
        constraints: What it shall keep.
        margin: Distance to keep [m]; None for the scene's.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: A motion is of other joints or none, `time` is not within `running`, or a
            limit or constraint makes no sense.
        RetimingFailed: A joint is planar or floating, or no state of the other motion is reached.
        NotCertified: No way over can be proven; evidence has the failed checks of the last.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    running_motion = _make_running_motion(world, group, running, options, constraints, margin)
    _validate_time(running, time)
    _validate_motion(running_motion.group, onto, "onto")
    return running_motion.certify_first(_splices(running_motion, time, onto, deadline), deadline)


def _splices(
    running_motion: _RunningMotion, time: float, onto: TimedTrajectory, deadline: Deadline
) -> Iterator[TimedTrajectory]:
    """Yield ways into the other motion, soonest over first.

    Raises:
        RetimingFailed: No state of the other motion is reached.
        DeadlineExceeded: Time ran out.
        Canceled: The end was asked for.
    """
    running, limits = running_motion.running, running_motion.limits
    state = MotionState.of(running, time)
    splices: list[TimedTrajectory] = []
    failure: RetimingFailed | None = None
    for instant in np.linspace(0.0, onto.duration, _NUM_JOIN_TIMES)[:-1]:
        deadline.check("retime")
        try:
            target_state = MotionState.of(onto, float(instant))
            transition = to_state(
                running.joints, limits, state, target_state, running_motion.acceleration_bounds
            )
        except RetimingFailed as error:
            failure = error
            continue
        splices.append(TimedTrajectory.joined([transition, onto.after(float(instant))]))
    if not splices and failure is not None:
        raise failure
    yield from sorted(splices, key=lambda motion: motion.duration)


def _make_running_motion(
    world: World,
    group: str,
    running: TimedTrajectory,
    options: RetimeOptions | None,
    constraints: tuple[PathConstraint, ...],
    margin: float | None,
) -> _RunningMotion:
    """Return what is left, once it makes sense."""
    joints = world.group(group)
    _validate_motion(joints, running, "running")
    validate_constraints(world, joints, constraints)
    retiming = resolve_retiming(
        world, joints, options or RetimeOptions("ruckig"), running.start, "options."
    )
    return _RunningMotion(world, joints, running, retiming, constraints, margin)


def _validate_motion(group: JointGroup, motion: TimedTrajectory, field: str) -> None:
    """Go on only if a motion is one of a group's joints, and its times begin at 0 and increase."""
    validate_joints(group, motion, field)
    numbers = (motion.breaks, motion.bases, motion.coefficients)
    is_timed = motion.breaks[0] == 0 and bool((np.diff(motion.breaks) > 0).all())
    if not (is_timed and all(np.isfinite(array).all() for array in numbers)):
        message = f"{field}: all its numbers must be finite, and its times increase, from 0"
        raise ProblemInvalid(message, {"field": field})


def _validate_time(running: TimedTrajectory, time: float) -> None:
    if not 0 <= time <= running.duration:
        message = f"time: {time:g} s is not within the motion, from 0 to {running.duration:.9g} s"
        evidence = {"field": "time", "bounds": [0.0, running.duration], "got": time}
        raise ProblemInvalid(message, evidence)
