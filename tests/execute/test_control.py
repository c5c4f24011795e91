"""Commands while it moves, in any order: the setpoints stay on the path and within all limits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation import trajectory_through
from planning.domain.robot.joints import Joint, JointLimits, JointType
from planning.errors import IllegalTransition, TorqueLimitReached, TrackingLost
from planning.execute.driver import Setpoint
from planning.execute.execution import Execution
from tests.execute.conftest import EFFORT, EchoDriver
from tests.profiles import num_cases

PERIOD = 0.004
JOINTS = (Joint("body::base", JointType.PLANAR), Joint("arm::a", JointType.REVOLUTE))
BLOCKS = ((0, 1), (2,), (3,))


def random_motion(seed: int) -> TimedTrajectory:
    """Return a cubic spline from rest to rest through a few places."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 5))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.15, 0.5, count))])
    return trajectory_through(JOINTS, times, rng.uniform(-0.5, 0.5, (count + 1, 4)))


def norms(rates: np.ndarray) -> np.ndarray:
    """Return the norm of every block, shape (m, num_blocks)."""
    return np.stack([np.linalg.norm(rates[:, list(block)], axis=1) for block in BLOCKS], axis=1)


def tight_limits(motion: TimedTrajectory, slack: float) -> JointLimits:
    """Return limits that a motion just keeps."""
    times = np.union1d(np.linspace(0.0, motion.duration, 4001), motion.breaks)
    rest = np.full(4, np.inf)
    velocity, acceleration = (
        norms(rates).max(axis=0) * slack
        for rates in (motion.velocities(times), motion.accelerations(times))
    )
    none = np.full(3, np.inf)
    return JointLimits(-rest, rest, velocity, acceleration, none, none, BLOCKS)


COMMAND = st.one_of(
    st.floats(-1.0, 1.0),
    st.sampled_from([0.0, 1.0, -1.0, 1e-3]),
    st.sampled_from(["pause", "resume"]),
)


def commanded(execution: Execution, command: Any) -> Execution:
    try:
        if isinstance(command, float):
            return execution.with_speed(command)
        return execution.pause() if command == "pause" else execution.resume()
    except IllegalTransition:
        assert execution.state.is_terminal
        return execution


def follow(
    execution: Execution, commands: list[tuple[int, Any]], *, cancels: bool, driver: EchoDriver
) -> tuple[Execution, list[float]]:
    """Carry out commands, each some steps after the last one, and then let it end."""
    due, at = {}, 0
    for wait, command in commands:
        at += wait
        due[at] = command
    execution, places = execution.start(), list[float]()
    measured = replace(driver.read(0.0), q=execution.desired, v=np.zeros(4))
    for i in range(20_000):
        if i in due:
            execution = commanded(execution, due[i])
        elif i == at + 1 and not execution.state.is_terminal:
            execution = execution.cancel() if cancels else execution.resume().with_speed(1.0)
        places.append(execution.time)
        execution, setpoint = execution.step(measured, PERIOD)
        driver.send(setpoint)
        if execution.state.is_terminal:
            return execution, places
        measured = driver.read(measured.time + PERIOD)
    pytest.fail("it does not end")


def assert_kept(sent: list[Setpoint], motion: TimedTrajectory, limits: JointLimits) -> None:
    """Assert that setpoints are smooth, keep the limits, and stay on the path."""
    q, v, vdot = (np.array([getattr(s, name) for s in sent]) for name in ("q", "v", "vdot"))
    assert np.all(norms(v) <= limits.velocity * (1 + 1e-9))
    assert np.all(norms(vdot) <= limits.acceleration * (1 + 1e-9))
    # by finite differences of what was sent: neither positions nor velocities jump
    assert np.all(norms(np.diff(v, axis=0)) <= 1.05 * limits.acceleration * PERIOD)
    ahead = q[:-1] + 0.5 * PERIOD * (v[:-1] + v[1:])
    assert np.all(norms(q[1:] - ahead) <= limits.acceleration * PERIOD**2)
    path = motion.positions(np.linspace(0.0, motion.duration, 3001))
    spacing = np.linalg.norm(np.diff(path, axis=0), axis=1).max()
    away = [np.linalg.norm(path - row, axis=1).min() for row in q[::7]]
    assert max(away) <= spacing


@settings(max_examples=num_cases(12), deadline=None)
@given(
    st.integers(0, 10_000),
    st.floats(1.001, 2.0),
    st.lists(st.tuples(st.integers(1, 120), COMMAND), max_size=8),
    st.booleans(),
)
def test_any_commands_keep_the_limits_and_the_path(
    seed: int, slack: float, commands: list[tuple[int, Any]], cancels: bool
) -> None:
    motion = random_motion(seed)
    limits, driver = tight_limits(motion, slack), EchoDriver()
    done, places = follow(Execution(motion, limits), commands, cancels=cancels, driver=driver)
    assert_kept(driver.sent, motion, limits)
    assert done.failure is None
    assert not np.any(driver.sent[-1].v)
    if done.state == "succeeded":
        assert done.time == motion.duration
        np.testing.assert_allclose(driver.sent[-1].q, motion.end, atol=1e-12)
    else:
        assert cancels
        assert done.state == "canceled"
    # it may be at the end before, but goes on until it rests there
    assert all(0.0 <= place <= motion.duration for place in places)


def test_it_goes_back_to_its_beginning_and_waits_there(execution: Execution) -> None:
    driver, back = EchoDriver(), []
    running = execution.start()
    measured = driver.read(0.0)
    for i in range(1500):
        if i == 250:
            running = running.with_speed(-1.0)
        running, setpoint = running.step(measured, PERIOD)
        driver.send(setpoint)
        back.append(running.path_velocity)
        measured = driver.read(measured.time + PERIOD)
    assert (running.state, running.time, running.path_velocity) == ("executing", 0.0, 0.0)
    assert min(back) == -1.0
    np.testing.assert_allclose(measured.q, execution.trajectory.start, atol=1e-9)
    forward = running.with_speed(1.0)
    for _ in range(1500):
        forward, setpoint = forward.step(measured, PERIOD)
        driver.send(setpoint)
        if forward.state.is_terminal:
            break
        measured = driver.read(measured.time + PERIOD)
    assert (forward.state, forward.time) == ("succeeded", 2.0)


def test_speed_zero_rests_on_the_path_while_it_is_executing(execution: Execution) -> None:
    driver, running = EchoDriver(), execution.start()
    measured = driver.read(0.0)
    for i in range(1500):
        running = running.with_speed(0.0) if i == 250 else running
        running, setpoint = running.step(measured, PERIOD)
        driver.send(setpoint)
        measured = driver.read(measured.time + PERIOD)
    assert (running.state, running.path_velocity) == ("executing", 0.0)
    assert 1.0 < running.time < 1.2
    assert running.cancel().step(measured, PERIOD)[0].state == "canceling"


def test_progress_is_a_share_of_the_path_and_shrinks_on_the_way_back(execution: Execution) -> None:
    """The quintic has done x of its way at 10 x^3 - 15 x^4 + 6 x^5 of its time, by symmetry."""
    trajectory = execution.trajectory
    for x in (0.0, 0.2, 0.5, 0.9, 1.0):
        done = 10 * x**3 - 15 * x**4 + 6 * x**5
        assert trajectory.path_fraction(2.0 * x) == pytest.approx(done, abs=1e-5)
    still = TimedTrajectory(
        trajectory.joints, np.array([0.0, 1.0]), np.zeros((1, 2)), np.zeros((1, 2, 2))
    )
    assert still.path_fraction(0.25) == pytest.approx(0.25)


def steps(execution: Execution, driver: EchoDriver, count: int) -> list[Execution]:
    """Return the execution after every step, until it has ended."""
    measured, told = driver.read(0.0), list[Execution]()
    for _ in range(count):
        execution, setpoint = execution.step(measured, PERIOD)
        driver.send(setpoint)
        told.append(execution)
        if execution.state.is_terminal:
            break
        measured = driver.read(measured.time + PERIOD)
    return told


def test_a_joint_at_its_torque_limit_stops_on_the_path_and_says_which(
    execution: Execution,
) -> None:
    driver = EchoDriver(torques=np.array([1e6, 0.9995 * EFFORT]))
    told = steps(execution.start(), driver, 2000)
    last, bound = told[-1], execution.tolerances.saturation_time
    assert last.state == "aborted"
    assert isinstance(last.failure, TorqueLimitReached)
    evidence = last.failure.evidence
    assert evidence["joint"] == "arm::b"  # the other one has no limit
    assert (evidence["torque"], evidence["bound"]) == (0.9995 * EFFORT, EFFORT)
    assert bound < evidence["seconds"] <= bound + 2 * PERIOD
    # it comes to rest along its path, not at once
    assert sum(each.state == "aborting" for each in told) >= 20
    assert last.time > evidence["time"] > 0
    assert_on_path(driver.sent, execution.trajectory)


def test_a_torque_that_is_at_its_limit_now_and_then_is_no_failure(execution: Execution) -> None:
    driver = EchoDriver(torques=np.array([0.0, EFFORT]))
    running, measured = execution.start(), driver.read(0.0)
    for i in range(700):
        driver.torques = np.array([0.0, EFFORT if i % 50 else 0.0])
        running, setpoint = running.step(measured, PERIOD)
        driver.send(setpoint)
        measured = driver.read(measured.time + PERIOD)
    assert running.state == "succeeded"


def test_a_contact_on_the_way_to_rest_is_held_at_once(execution: Execution) -> None:
    driver = EchoDriver(torques=np.array([0.0, EFFORT]))
    driver.touches_at = 0.3  # while it brakes along its path
    told = steps(execution.start(), driver, 2000)
    assert told[-1].state == "aborted"
    assert isinstance(told[-1].failure, TorqueLimitReached)  # the first reason stays
    assert told[-1].held is not None
    assert told[-1].driver_time <= 0.3 + 3 * PERIOD


def test_an_aborted_motion_stays_aborted_whatever_is_asked(execution: Execution) -> None:
    driver = EchoDriver(torques=np.array([0.0, EFFORT]))
    told = steps(execution.start(), driver, 2000)
    braking = next(each for each in told if each.state == "aborting")
    assert braking.cancel() == braking
    for command in (Execution.pause, Execution.resume, lambda one: one.with_speed(0.5)):
        with pytest.raises(IllegalTransition):
            command(braking)


def test_a_robot_that_never_rests_is_aborted_in_time(execution: Execution) -> None:
    class Shaking(EchoDriver):
        def read(self, time: float) -> Any:
            return replace(super().read(time), v=np.full(2, 0.5))

    told = steps(execution.start(), Shaking(offset=0.2), 2000)
    assert told[-1].state == "aborted"
    assert isinstance(told[-1].failure, TrackingLost)
    assert told[-1].driver_time <= execution.tolerances.settle_time + 3 * PERIOD


def assert_on_path(sent: list[Setpoint], motion: TimedTrajectory) -> None:
    path = motion.positions(np.linspace(0.0, motion.duration, 3001))
    assert max(np.linalg.norm(path - s.q, axis=1).min() for s in sent) < 1e-3


def test_between_both_ways_it_is_at_rest_for_an_instant(execution: Execution) -> None:
    """There s'' may jump, and both |q'' s'^2 + q' s''| <= a at the ends of a period suffice."""
    running, measured = execution.start(), EchoDriver().read(0.0)
    velocities = list[float]()
    driver = EchoDriver()
    for i in range(400):
        running = running.with_speed(-1.0) if i == 250 else running
        running, setpoint = running.step(measured, PERIOD)
        driver.send(setpoint)
        velocities.append(running.path_velocity)
        measured = driver.read(measured.time + PERIOD)
    signs = np.sign(velocities)
    assert not np.any(signs[1:] * signs[:-1] < 0)
    assert 0.0 in velocities[250:]


def test_who_goes_back_at_the_very_end_has_not_succeeded(execution: Execution) -> None:
    driver = EchoDriver()
    running, measured = execution.start(), driver.read(0.0)
    for _ in range(1200):
        if running.time == execution.trajectory.duration:
            running = running.with_speed(-0.5)
        running, setpoint = running.step(measured, PERIOD)
        driver.send(setpoint)
        measured = driver.read(measured.time + PERIOD)
    assert running.state == "executing"
    assert running.time < execution.trajectory.duration
