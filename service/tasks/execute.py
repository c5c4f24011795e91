"""Executing a plan in simulation, as a job."""

import threading
import time
from pathlib import Path
from typing import Any

from planning import Simulation, World
from planning.errors import Canceled
from planning.execute.driver import SimulatedDriver
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from planning.execute.states import ExecutionState
from service.convert.executions import StatusLog
from service.convert.trajectories import trajectory_value
from service.executions.controls import Controls, read_controls
from service.tasks.channel import Channel
from service.tasks.worlds import borrow_world

_TICK = 0.01
_EVENT_PERIOD = 0.05


def execute(payload: dict[str, Any], channel: Channel) -> dict[str, Any]:
    """Follow a plan until it has ended; every `status` event says how it goes.

    Returns:
        `status`: the last one.

    Raises:
        Canceled: Somebody asked for the end; the robot came to rest on its path first.
        ExecutionFailure: The robot left its trajectory or touched something.
    """
    with borrow_world(payload) as world:
        runner = _runner(world, payload)
        last = _run(runner, channel, Path(payload["controls"]), payload["speed"])
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


def _run(runner: Runner, channel: Channel, controls: Path, speed: float) -> dict[str, Any]:
    """Tick until it has ended and return the last status."""
    log, told_at, told_state = StatusLog(), 0.0, ExecutionState.ACCEPTED
    obeyed = Controls(is_paused=False, speed=speed)
    pulse = threading.Event()
    runner.start(time.monotonic())
    while True:
        obeyed = _obey(runner, channel, controls, obeyed)
        now = time.monotonic()
        status = log.wire(runner.tick(now))
        state = runner.execution.state
        if state is not told_state or now - told_at > _EVENT_PERIOD:
            told_state, told_at = state, now
            channel.emit("status", status)
        if runner.is_done:
            return status
        pulse.wait(_TICK)


def _obey(runner: Runner, channel: Channel, controls: Path, obeyed: Controls) -> Controls:
    """Do what was asked since the last tick; return what is obeyed now."""
    if runner.is_done or runner.execution.state is ExecutionState.CANCELING:
        return obeyed
    if channel.is_canceled():
        runner.cancel()
        return obeyed
    asked = read_controls(controls, obeyed.speed)
    if asked.speed != obeyed.speed:
        runner.set_speed(asked.speed)
    if asked.is_paused and not obeyed.is_paused:
        runner.pause()
    if obeyed.is_paused and not asked.is_paused:
        runner.resume()
    return asked
