"""Executing a plan in simulation, as a job."""

import threading
import time
from collections.abc import Callable
from typing import Any

from planning import Simulation, World
from planning.errors import Canceled
from planning.execute.driver import SimulatedDriver
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from planning.execute.states import ExecutionState
from service.executions.controls import IS_PAUSED, SPEED
from service.executions.conversion import StatusLog
from service.jobs.context import TaskContext
from service.plans.models.trajectory_conversion import trajectory_value
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world

# How long a tick takes, or works [s].
TICK = 0.01
_EVENT_PERIOD = 0.05
# A process that says nothing for so long hangs [s]: it says how it goes twenty times a second.
LONGEST_SILENCE = 3.0


def execute(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Follow a plan until it has ended; every `status` event says how it goes.

    Returns:
        `status`: the last one.

    Raises:
        Canceled: The end was asked for; the robot came to rest on its path first.
        ExecutionFailure: The robot left its trajectory or touched something.
    """
    with borrow_world(SceneWork.model_validate(payload)) as world:
        runner = _runner(world, payload)
        last = follow(runner, channel, payload["speed"])
    if runner.execution.failure is not None:
        raise runner.execution.failure
    if runner.execution.state is ExecutionState.CANCELED:
        message = f"canceled {runner.status.time:.2f} s into the motion"
        raise Canceled(message, {"time": runner.status.time})
    return {"status": last}


def _runner(world: World, payload: dict[str, Any]) -> Runner:
    trajectory = trajectory_value(payload["trajectory"])
    group = world.group(payload["group"])
    simulation = Simulation(world, group, trajectory.start)
    execution = Execution(trajectory, world.limits(group))
    runner = Runner(execution, SimulatedDriver(simulation))
    runner.set_speed(payload["speed"])
    return runner


def follow(
    runner: Runner,
    channel: TaskContext,
    speed: float,
    clock: Callable[[], float] = time.monotonic,
    wait: Callable[[float], object] | None = None,
) -> dict[str, Any]:
    """Tick until it has ended and return the last status.

    Between two looks at what is asked lies a tick, whatever the speed and however slow the
    simulation: a tick works for `TICK` seconds and one step at most.

    Args:
        runner: That has not begun.
        channel: Told of it, and asked what is asked.
        speed: That the runner has.
        clock: Shows the time [s].
        wait: Lets so many seconds pass.
    """
    wait = wait or threading.Event().wait
    log, told_at, told_state = StatusLog(), 0.0, ExecutionState.ACCEPTED
    obeyed = {IS_PAUSED: False, SPEED: speed}
    channel.watch(LONGEST_SILENCE)
    until = clock()
    runner.start(until)
    while True:
        obeyed = _obey(runner, channel, obeyed)
        now = clock()
        log.late(now - until)
        until = now + TICK
        status = log.wire(runner.tick(now, lambda until=until: clock() < until))
        state = runner.execution.state
        if state is not told_state or now - told_at > _EVENT_PERIOD:
            told_state, told_at = state, now
            channel.update("status", status)
        if runner.is_done:
            return status
        if (left := until - clock()) > 0:
            wait(left)


def _obey(runner: Runner, channel: TaskContext, obeyed: dict[str, Any]) -> dict[str, Any]:
    """Do what was asked since the last tick; return what is obeyed now."""
    if runner.is_done or runner.execution.state is ExecutionState.CANCELING:
        return obeyed
    if channel.is_canceled():
        runner.cancel()
        return obeyed
    asked = obeyed | channel.controls()
    if asked[SPEED] != obeyed[SPEED]:
        runner.set_speed(asked[SPEED])
    if asked[IS_PAUSED] and not obeyed[IS_PAUSED]:
        runner.pause()
    if obeyed[IS_PAUSED] and not asked[IS_PAUSED]:
        runner.resume()
    return asked
