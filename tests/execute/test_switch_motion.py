"""An execution that goes on with another motion sends no setpoint that jumps."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.errors import ProblemInvalid
from planning.execute.execution import Execution
from planning.execute.switch_motion import switch_motion
from tests.execute.conftest import EchoDriver, limits, quintic
from tests.execute.test_barriers import stepped
from tests.execute.test_control import PERIOD, random_motion, tight_limits
from tests.profiles import num_cases


def to_rest(motion: TimedTrajectory, leave: float, shift: float) -> TimedTrajectory:
    """A motion of 1 s from a place of another one, with its velocity there, to rest elsewhere."""
    at = np.array([leave])
    q, v = motion.positions(at)[0], motion.velocities(at)[0]
    cubic = np.stack([0 * v, v, 3 * shift - 2 * v, v - 2 * shift])
    return TimedTrajectory(motion.joints, np.array([0.0, 1.0]), q[None], cubic[None])


@settings(max_examples=num_cases(3), deadline=None)
@given(st.integers(0, 10_000), st.floats(0.2, 0.8), st.floats(0.3, 1.0), st.integers(0, 60))
def test_a_splice_may_come_at_any_time_before_it_is_left(
    seed: int, share: float, speed: float, steps: int
) -> None:
    motion = random_motion(seed)
    driver, leave = EchoDriver(), share * motion.duration
    whole = TimedTrajectory.joined([motion.until(leave), to_rest(motion, leave, 0.3)])
    bounds = tight_limits(whole, 1.2)
    running = Execution(motion, bounds, speed=speed).between(None, leave).start()
    moving, _ = stepped(running, driver, steps)
    switched = switch_motion(moving, whole, moving.time)
    assert (switched.ahead, switched.behind) == (None, None)
    done, _ = stepped(switched.with_speed(1.0), driver, 4000)
    assert done.state == "succeeded"
    v = np.array([setpoint.v for setpoint in driver.sent])
    q = np.array([setpoint.q for setpoint in driver.sent])
    assert np.abs(np.diff(v, axis=0)).max() <= 1.05 * bounds.acceleration.max() * PERIOD
    ahead = q[:-1] + 0.5 * PERIOD * (v[:-1] + v[1:])
    assert np.abs(q[1:] - ahead).max() <= bounds.acceleration.max() * PERIOD**2


def test_at_rest_it_goes_on_from_the_beginning_of_a_motion() -> None:
    motion, driver = quintic(), EchoDriver()
    waiting, _ = stepped(Execution(motion, limits()).between(None, 0.8).start(), driver, 600)
    assert waiting.path_velocity == 0.0
    moves = to_rest(motion, waiting.time, 0.2)
    still = TimedTrajectory(moves.joints, moves.breaks, moves.bases, moves.coefficients * 0.0)
    switched = switch_motion(waiting, still, 0.0)
    assert (switched.time, switched.state) == (0.0, "executing")
    faster = replace(waiting, motion=replace(waiting.motion, velocity=0.5))
    with pytest.raises(ProblemInvalid, match="velocity differs"):
        switch_motion(faster, still, 0.0)


@pytest.mark.parametrize("place", [-0.1, 0.5, 3.0])
def test_a_motion_that_is_elsewhere_is_refused(place: float) -> None:
    moving, _ = stepped(Execution(quintic(), limits()).start(), EchoDriver(), 200)
    with pytest.raises(ProblemInvalid, match="from where the robot should be"):
        switch_motion(moving, quintic(), place)
    assert switch_motion(moving, quintic(), moving.time).trajectory is not None
