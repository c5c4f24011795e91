"""stop_motion() and splice_motion(): motions from a running motion to rest or to another motion."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from planning.api.certify_trajectory import validate_motion
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
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.retime.jerk.state_to_state import to_rest, to_state
from planning.retime.jerk.stop_along_path import stops_along
from planning.retime.limits.request_limits import path_limits
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.world import World

# Number of instants at which the other motion may be joined.
_NUM_JOIN_TIMES = 12


@dataclass(frozen=True, eq=False)
class ProvenMotion(Value):
    """Certified motion that continues a running motion.

    Attributes:
        trajectory: Motion from the instant on; its first velocity need not be zero.
        certificate: Certificate of the motion, jerk and continuity of acceleration included.
        certify: Report of the certification.
    """

    trajectory: TimedTrajectory
    certificate: Certificate
    certify: CertifyReport


@dataclass(frozen=True)
class _RunningMotion:
    """Running motion, and the limits and constraints of the motions that continue it."""

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
        """Return the first motion that is certified.

        Args:
            motions: Motions that continue the running one, best first.
            deadline: Time limit.
            has_jerk_limit: Whether jerk is limited, from the first instant on.
        """
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
            return ProvenMotion(
                *first_certified(named_motions, certify_motion, lambda motion: motion, Refusals())
            )


def stop_motion(  # noqa: PLR0913  (all inputs of a request)
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
    """Return the quickest certified stop from an instant of a motion, under jerk limits.

    Every joint brakes independently, so the stop leaves the path. It is certified like any motion,
    for the limits, constraints and margin given here; those of the running motion are not known.
    Along the path, the stop is the running motion slowed down by the quickest speed profile of a
    family; at worst it ends where the running motion ends.

    Args:
        world: Loaded scene.
        group: Joint group that moves, `robot` or `robot::group`.
        running: The running motion.
        time: Instant at which the stop begins [s].
        deadline: Time limit.
        options: Scales of the limits, and limits besides those of joints; None for the defaults
            under jerk limits. Of the other options only `method` has an effect, on a stop along the
            path: "toppra" lets accelerations jump, from the first instant on, "ruckig" does not.
            Options and constraints relative to the start refer to the start of `running`.
        constraints: Path constraints.
        margin: Required distance of bodies [m]; None for the scene's.
        along_path: Whether the stop stays on the path of `running`.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: `running` is of other joints or malformed, `time` is not within it, or a
            limit or constraint is invalid.
        RetimingFailed: A joint is planar or floating, or there is no such stop; never along the
            path.
        NotCertified: The stop is not proven; evidence has the failed checks.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    running_motion = _make_running_motion(world, group, running, options, constraints, margin)
    _validate_time(running, time)
    if along_path:
        limits_along_path = path_limits(world, running_motion.group, running_motion.options)
        has_jerk_limit = running_motion.options.limits_jerk
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


def splice_motion(  # noqa: PLR0913  (all inputs of a request)
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
    """Return the quickest certified motion from an instant of a motion onto another, without rest.

    The other motion is joined at one of several instants, in its state of position, velocity and
    acceleration there; the result that ends first is preferred. All of it, the rest of the other
    motion included, is certified for the limits, constraints and margin given here.

    Args:
        world: Loaded scene.
        group: Joint group that moves, `robot` or `robot::group`.
        running: The running motion.
        time: Instant at which it is left [s].
        onto: Motion that is joined.
        deadline: Time limit.
        options: Scales of the limits, and limits besides those of joints; None for the defaults
            under jerk limits. Other options have no effect. Options and constraints relative to the
            start refer to the start of `running`.
        constraints: Path constraints.
        margin: Required distance of bodies [m]; None for the scene's.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: A motion is of other joints or malformed, `time` is not within `running`, or
            a limit or constraint is invalid.
        RetimingFailed: A joint is planar or floating, or no state of the other motion is reached.
        NotCertified: No transition is proven; evidence has the failed checks of the last one.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
    """
    running_motion = _make_running_motion(world, group, running, options, constraints, margin)
    _validate_time(running, time)
    validate_motion(running_motion.group, onto, "onto")
    return running_motion.certify_first(_splices(running_motion, time, onto, deadline), deadline)


def _splices(
    running_motion: _RunningMotion, time: float, onto: TimedTrajectory, deadline: Deadline
) -> Iterator[TimedTrajectory]:
    """Yield transitions with the rest of the other motion, shortest duration first.

    Raises:
        RetimingFailed: No state of the other motion is reached.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
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
    """Return the running motion after checks of its input."""
    joints = world.group(group)
    validate_motion(joints, running, "running")
    validate_constraints(world, joints, constraints)
    retiming = resolve_retiming(
        world, joints, options or RetimeOptions("ruckig"), running.start, "options."
    )
    return _RunningMotion(world, joints, running, retiming, constraints, margin)


def _validate_time(running: TimedTrajectory, time: float) -> None:
    if not 0 <= time <= running.duration:
        message = f"time: {time:g} s is not within the motion, from 0 to {running.duration:.9g} s"
        evidence = {"field": "time", "bounds": [0.0, running.duration], "got": time}
        raise ProblemInvalid(message, evidence)
