"""Carrying a motion out, as a job."""

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace

import numpy as np

from planning import World
from planning.domain.report.motion_plan import Progress
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointGroup
from planning.errors import Canceled, PathBlocked
from planning.errors import Contact as TouchFailure
from planning.execute import status as domain
from planning.execute.abort_reasons import tracking_failure
from planning.execute.driver import Driver
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from planning.execute.states import ExecutionState
from planning.execute.tolerances import FINGER_TOLERANCES, Tolerances
from planning.world.mechanics.grippers import gripper_of
from service.executions.drivers.drivers import driver_of, sampling_reserve
from service.executions.drivers.jitter import JitterLog
from service.executions.gripping.settling import Settling
from service.executions.models import Contact, ExecutionStatus, SamplingReserve
from service.executions.motions.followed_motions import FollowedMotions
from service.executions.tasks import (
    EXECUTE,
    START_TOLERANCE,
    Block,
    Commands,
    ExecutionOutcome,
    ExecutionWork,
    Touch,
)
from service.jobs.context import TaskContext
from service.jobs.worker.progress import ProgressReporter
from service.scenes.world_cache import borrow_world

# How long a tick takes, or works [s].
TICK = 0.01
_EVENT_PERIOD = 0.05
# In these it comes to rest, whatever is asked of it.
_ENDING = {ExecutionState.CANCELING, ExecutionState.ABORTING}
# A process that sends nothing for so long hangs [s]: it sends its status twenty times a second.
MAX_SILENCE = 3.0


@EXECUTE.runs
def execute(work: ExecutionWork, context: TaskContext) -> ExecutionOutcome:
    """Follow a motion until it has ended; every `status` event says how far it is.

    Raises:
        Canceled: The end was asked for; the robot came to rest on its path first.
        ExecutionFailure: The robot left its trajectory, touched something, or is lost.
        NotCertified: A controller samples the motion, and its clearance is too small for that.
    """
    log = ProgressReporter(context)
    watch = Stopwatch(time.monotonic, lambda stage: log(Progress(stage, 0.0)))
    with watch.timing_failures(), ExitStack() as stack:
        with watch.stage("load"):
            world = stack.enter_context(borrow_world(work))
        with watch.stage("execute"):
            runner, driver, sampling = _runner(world, work)
            stack.callback(runner.stop)
            settling = Settling(world, work, driver)
            status = _carried_out(runner, context, work.speed, settling)
    return ExecutionOutcome(status=status, timings=watch.seconds_by_name, sampling=sampling)


def _carried_out(
    runner: Runner, context: TaskContext, speed: float, settling: Settling
) -> ExecutionStatus:
    """Return the last status of an execution that has reached its end; raises as `execute`."""
    status = follow(runner, context, speed, settling=settling)
    if settling.failure is not None:
        raise settling.failure
    if runner.execution.failure is not None:
        raise runner.execution.failure
    if runner.execution.state is ExecutionState.CANCELED:
        message = f"canceled {runner.status.time:.2f} s into the motion"
        raise Canceled(message, {"time": runner.status.time})
    return status


def _runner(world: World, work: ExecutionWork) -> tuple[Runner, Driver, SamplingReserve | None]:
    trajectory = work.trajectory.to_domain()
    group = world.group(work.group)
    world = _with_force(world, group, work)
    sampling = sampling_reserve(work, world, group, trajectory)
    driver = driver_of(work, world, group, trajectory)
    tolerances = Tolerances() if gripper_of(world, group) is None else FINGER_TOLERANCES
    runner = Runner(Execution(trajectory, world.limits(group), tolerances), driver)
    error = runner.status.tracking_error
    if error > START_TOLERANCE:  # a robot may be elsewhere than the scene says
        runner.stop()
        raise tracking_failure(error, START_TOLERANCE, 0.0)
    runner.set_speed(work.speed)
    return runner, driver, sampling


def _with_force(world: World, group: JointGroup, work: ExecutionWork) -> World:
    """Return the world in which a gripper has the force that was asked for."""
    gripper = work.request.gripper
    if gripper is None or gripper.force is None:
        return world
    limits = world.limits(group)
    return world.with_limits(
        group, replace(limits, effort=np.minimum(limits.effort, gripper.force))
    )


def follow(
    runner: Runner,
    context: TaskContext,
    speed: float,
    clock: Callable[[], float] | None = None,
    wait: Callable[[float], object] | None = None,
    settling: Settling | None = None,
) -> ExecutionStatus:
    """Tick until the execution has ended and return its last status.

    Between two looks at the commands lies a tick, whatever the speed and however slow the
    simulation: a tick works for `TICK` seconds and one step at most.

    Args:
        runner: That has not begun.
        context: Has the commands, and is sent every status.
        speed: That the runner has.
        clock: Shows the time [s]; None for that of the process.
        wait: Waits for a number of seconds.
        settling: What is measured once the motion has ended; None for nothing more.
    """
    # Not a default of the parameter: that would be whatever clock was there at the import.
    clock = clock or time.monotonic
    wait = wait or threading.Event().wait
    log, sent_at, sent_state = _StatusLog(), 0.0, ExecutionState.ACCEPTED
    applied, motions = Commands(speed=speed), FollowedMotions(runner, context)
    context.watch(MAX_SILENCE)
    until = clock()
    runner.start(until)
    while True:
        applied = _apply_commands(runner, context, applied, motions)
        now = clock()
        log.note_delay(now - until)
        until = now + TICK
        measured = log.enter(runner.tick(now, lambda until=until: clock() < until))
        status = measured.model_copy(update={"motion": motions.number})
        if runner.is_done and settling is not None:
            status = settling.settled(status, runner.status.driver_time)
        state = runner.execution.state
        if state is not sent_state or now - sent_at > _EVENT_PERIOD:
            sent_state, sent_at = state, now
            context.update("status", status.model_dump(mode="json"))
        if runner.is_done:
            return status
        if (left := until - clock()) > 0:
            wait(left)


def _apply_commands(
    runner: Runner, context: TaskContext, applied: Commands, motions: FollowedMotions
) -> Commands:
    """Carry out the commands since the last tick; return those that are carried out now."""
    if runner.is_done or runner.execution.state in _ENDING:
        return applied
    if context.is_canceled():
        runner.cancel()
        return applied
    controls = context.controls()
    if controls is motions.controls:  # nothing new: they may have a whole motion
        return applied
    motions.controls = controls
    latest = Commands.model_validate({"speed": applied.speed} | controls)
    if _is_aborted(runner, latest):
        return latest
    motions.heed(latest)
    if latest.speed is not None and latest.speed != applied.speed:
        runner.set_speed(latest.speed)
    if latest.is_paused and not applied.is_paused:
        runner.pause()
    if applied.is_paused and not latest.is_paused:
        runner.resume()
    return latest


def _is_aborted(runner: Runner, commands: Commands) -> bool:
    """Abort if commands say so; return whether they do."""
    if commands.touch is not None:
        runner.abort_at_once(touched(commands.touch))
    elif commands.block is not None:
        runner.abort(blocked(commands.block))
    return commands.touch is not None or commands.block is not None


def blocked(block: Block) -> PathBlocked:
    """Return the failure of a motion that is blocked."""
    what = " and ".join(block.pair) or block.check
    message = (
        f"the scene was edited (revision {block.revision}), and the motion does not hold any more "
        f"at {block.time:.3f} s, {block.fraction:.0%} of its path: {what}"
    )
    return PathBlocked(message, block.model_dump())


def touched(touch: Touch) -> TouchFailure:
    """Return the failure of a motion whose robot touches one that another execution moves."""
    message = (
        f"contact of {' and '.join(touch.pair)}, {touch.depth * 1000:.2f} mm deep, at "
        f"{touch.time:.3f} s: execution {touch.execution} moves the other robot"
    )
    return TouchFailure(message, {**touch.model_dump(), "force": None})


class _StatusLog:
    """Statuses with the worst of all before them: contacts, tracking errors, delays."""

    def __init__(self) -> None:
        self._max_error = 0.0
        self._delays = JitterLog()
        self._contacts: dict[tuple[str, str], Contact] = {}

    def note_delay(self, seconds: float) -> None:
        """Note how much later than it was due a look at the clock came [s]."""
        self._delays.note(seconds)

    def enter(self, status: domain.ExecutionStatus) -> ExecutionStatus:
        """Return a status as clients see it."""
        self._max_error = max(self._max_error, status.tracking_error)
        for contact in status.contacts:
            depth = max(0.0, -contact.distance)
            touch = Contact(
                bodies=contact.bodies, depth=depth, force=contact.force, time=status.time
            )
            known = self._contacts.get(contact.bodies, touch)
            self._contacts[contact.bodies] = _worst(known, touch)
        return ExecutionStatus.from_domain(
            status, self._max_error, self._delays.jitter, list(self._contacts.values())
        )


def _worst(first: Contact, now: Contact) -> Contact:
    """Return a contact with the largest depth and force of two, and the time of the first."""
    forces = [touch.force for touch in (first, now) if touch.force is not None]
    depth = max(first.depth, now.depth)
    return first.model_copy(update={"depth": depth, "force": max(forces, default=None)})
