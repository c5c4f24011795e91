"""State, setpoints and failures of an execution, with a driver that follows exactly."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.errors import Contact, IllegalTransition, ProblemInvalid, TrackingLost
from planning.execute.driver import Setpoint
from planning.execute.execution import Execution
from tests.profiles import num_cases

PERIOD = 0.01
ACCELERATION = 3.0
type Commands = dict[int, Callable[[Execution], Execution]]


def follow(
    execution: Execution, driver: Any, commands: Commands | None = None, num_steps: int = 4000
) -> Execution:
    """Step until it ends, with commands at given steps."""
    measured = driver.read(0.0)
    for i in range(num_steps):
        execution = (commands or {}).get(i, lambda same: same)(execution)
        execution, setpoint = execution.step(measured, PERIOD)
        driver.send(setpoint)
        if execution.state.is_terminal:
            break
        measured = driver.read(measured.time + PERIOD)
    return execution


def assert_smooth(sent: list[Setpoint], acceleration: float) -> None:
    """Assert that what was sent keeps the acceleration limit and has no jump."""
    q, v, vdot = (np.array([getattr(s, name) for s in sent]) for name in ("q", "v", "vdot"))
    assert np.max(np.abs(vdot)) <= acceleration * (1 + 1e-6)
    assert np.max(np.abs(np.diff(v, axis=0))) <= acceleration * PERIOD * (1 + 1e-3)
    # what is sent belongs together: within a period vdot changes by its derivative only
    assert np.max(np.abs(np.diff(v, axis=0) - PERIOD * vdot[:-1])) <= 0.15 * acceleration * PERIOD
    assert np.max(np.abs(np.diff(q, axis=0) - PERIOD * v[:-1])) <= acceleration * PERIOD**2


def test_it_follows_the_trajectory_and_succeeds(execution: Execution, new_driver: Any) -> None:
    driver = new_driver()
    done = follow(execution.start(), driver)
    assert (done.state, done.time, done.failure) == ("succeeded", 2.0, None)
    times = np.minimum([s.time for s in driver.sent], 2.0)
    np.testing.assert_allclose(
        [s.q for s in driver.sent], execution.trajectory.positions(times), atol=1e-12
    )
    assert not np.any(driver.sent[-1].v)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 200), st.floats(0.05, 1.0))
def test_a_cancel_comes_to_rest_on_the_path_within_the_limits(
    execution: Execution, new_driver: Any, when: int, speed: float
) -> None:
    driver, started = new_driver(), execution.with_speed(speed).start()
    assert follow(started, new_driver(), num_steps=when).state == "executing"
    done = follow(started, driver, {when: Execution.cancel})
    assert done.state == "canceled"
    assert_smooth(driver.sent, ACCELERATION)
    assert not np.any(driver.sent[-1].v)
    np.testing.assert_allclose(driver.sent[-1].q, done.desired, atol=1e-12)
    # from full speed 1.875 / 2 rad/s a ramp within 3 rad/s^2 takes a fraction of a second
    assert done.driver_time <= when * PERIOD + 1.0


@settings(max_examples=num_cases(6))
@given(st.integers(0, 160), st.integers(1, 80), st.floats(0.3, 1.0))
def test_pause_and_resume_lose_nothing(
    execution: Execution, new_driver: Any, when: int, pause: int, speed: float
) -> None:
    driver = new_driver()
    commands: Commands = {
        when: Execution.pause,
        when + pause: lambda paused: paused.resume().with_speed(speed),
    }
    done = follow(execution.start(), driver, commands)
    assert (done.state, done.time) == ("succeeded", 2.0)
    assert_smooth(driver.sent, ACCELERATION)


def test_a_paused_robot_stands_still_on_its_path_for_as_long_as_it_takes(
    execution: Execution, new_driver: Any
) -> None:
    driver = new_driver()
    paused = follow(execution.start(), driver, {80: Execution.pause}, num_steps=400)
    assert (paused.state, paused.path_velocity) == ("paused", 0.0)
    assert 0.8 < paused.time < 1.3
    assert not np.any([s.v for s in driver.sent[-200:]])
    done = follow(paused.cancel(), driver)
    assert done.state == "canceled"


def test_half_speed_takes_twice_as_long_with_half_the_velocity(
    execution: Execution, new_driver: Any
) -> None:
    fast, slow = new_driver(), new_driver()
    end = follow(execution.start(), fast).driver_time
    end_slow = follow(execution.with_speed(0.5).start(), slow).driver_time
    assert end_slow - 2 * PERIOD == pytest.approx(2 * (end - PERIOD), abs=2 * PERIOD)
    peak, peak_slow = (np.max(np.abs([s.v for s in d.sent]), axis=0) for d in (fast, slow))
    np.testing.assert_allclose(peak_slow, peak / 2, rtol=1e-4)


def test_a_canceled_start_ends_where_it_is(execution: Execution, new_driver: Any) -> None:
    driver = new_driver()
    done = follow(execution.cancel(), driver)
    assert (done.state, done.time) == ("canceled", 0.0)


def test_a_contact_aborts_and_names_the_pair(execution: Execution, new_driver: Any) -> None:
    driver = new_driver(touches_at=0.5)
    done = follow(execution.start(), driver)
    assert done.state == "aborted"
    assert isinstance(done.failure, Contact)
    assert done.failure.evidence["pair"] == ["arm::link", "wall"]
    assert done.failure.evidence["depth"] == 0.002
    assert done.failure.evidence["time"] == pytest.approx(0.5, abs=PERIOD)
    assert not np.any(driver.sent[-1].v)


def test_a_robot_far_from_its_trajectory_is_lost(execution: Execution, new_driver: Any) -> None:
    done = follow(execution.start(), new_driver(offset=0.11))
    assert isinstance(done.failure, TrackingLost)
    assert done.failure.evidence["error"] == pytest.approx(0.11, abs=1e-5)
    assert done.failure.evidence["bound"] == 0.1


def test_a_robot_that_never_arrives_is_lost(execution: Execution, new_driver: Any) -> None:
    done = follow(execution.start(), new_driver(offset=0.02))
    assert isinstance(done.failure, TrackingLost)
    assert done.failure.evidence["bound"] == execution.tolerances.goal
    assert done.driver_time == pytest.approx(4.0, abs=0.05)  # the motion, and the time to settle


def test_a_step_changes_nothing_but_its_result(execution: Execution, new_driver: Any) -> None:
    started, measured = execution.start(), new_driver().read(0.0)
    first, second = started.step(measured, PERIOD), started.step(measured, PERIOD)
    assert first == second
    assert started == execution.start()
    assert first[0] != started


@pytest.mark.parametrize("speed", [-1.01, 1.01, float("nan"), float("inf")])
def test_speeds_that_break_the_limits_are_refused(execution: Execution, speed: float) -> None:
    with pytest.raises(ProblemInvalid, match="speed"):
        execution.with_speed(speed)


def test_an_ended_execution_refuses_all_commands(execution: Execution, new_driver: Any) -> None:
    done = follow(execution.start(), new_driver())
    commands = (Execution.start, Execution.pause, Execution.resume, Execution.cancel)
    for command in (*commands, lambda ended: ended.with_speed(0.5)):
        with pytest.raises(IllegalTransition):
            command(done)
