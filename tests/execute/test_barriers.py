"""Barriers on the path: it rests before them, within limits, and goes on once they are lifted."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.execute.execution import Execution
from planning.execute.path_motion import PathMotion
from tests.execute.conftest import EchoDriver
from tests.execute.test_control import PERIOD, assert_kept, random_motion, tight_limits
from tests.profiles import num_cases

# Steps until all that moves has come to rest, and until it has gone on to the end.
_RESTED, _DONE = 500, 1200
# How far before a barrier it may rest, as what is nearer is not worth the way [s].
_NEAR = 0.02


def stepped(execution: Execution, driver: EchoDriver, count: int) -> tuple[Execution, list[float]]:
    """Make steps, until it ends at the latest; return the places on the way too."""
    places = []
    measured = driver.read(driver.sent[-1].time + PERIOD if driver.sent else 0.0)
    if not driver.sent:
        measured = replace(measured, q=execution.desired, v=np.zeros(4))
    for _ in range(count):
        execution, setpoint = execution.step(measured, PERIOD)
        driver.send(setpoint)
        places.append(execution.time)
        if execution.state.is_terminal:
            break
        measured = driver.read(measured.time + PERIOD)
    return execution, places


@settings(max_examples=num_cases(5), deadline=None)
@given(st.integers(0, 10_000), st.floats(1.001, 2.0), st.floats(0.0, 1.0), st.integers(0, 120))
def test_it_rests_before_a_barrier_and_goes_on_once_it_is_lifted(
    seed: int, slack: float, share: float, steps: int
) -> None:
    motion = random_motion(seed)
    limits, driver = tight_limits(motion, slack), EchoDriver()
    place = share * motion.duration
    moving, _ = stepped(Execution(motion, limits).start(), driver, steps)
    kept = moving.between(None, place)
    assert kept.ahead is not None
    is_in_time = kept.path_velocity <= kept.ahead.max_speed(kept.time)
    rested, places = stepped(kept, driver, _RESTED)
    assert rested.path_velocity == 0.0
    if is_in_time:
        assert max(places) <= place
        assert rested.time >= place - _NEAR
        assert rested.state == "executing"
    done, _ = stepped(rested.between(None, None), driver, _DONE)
    assert done.state == "succeeded"
    assert_kept(driver.sent, motion, limits)


@settings(max_examples=num_cases(2), deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 0.7), st.floats(-1.0, -0.2))
def test_it_rests_before_a_barrier_on_the_way_back(seed: int, share: float, speed: float) -> None:
    motion = random_motion(seed)
    limits, driver = tight_limits(motion, 1.1), EchoDriver()
    place = share * motion.duration
    late = PathMotion(time=0.9 * motion.duration)
    began = replace(Execution(motion, limits).start(), motion=late, speed=speed)
    rested, places = stepped(began.between(place, None), driver, _DONE)
    assert (rested.state, rested.path_velocity) == ("executing", 0.0)
    assert place <= min(places)
    assert rested.time <= place + _NEAR
    back, _ = stepped(rested.between(None, None), driver, _DONE)
    assert back.time == 0.0
    assert_kept(driver.sent, motion, limits)


def test_what_is_too_quick_for_a_barrier_rests_as_soon_as_the_limits_allow() -> None:
    motion = random_motion(3)
    limits = tight_limits(motion, 1.5)
    moving, _ = stepped(Execution(motion, limits).start(), driver := EchoDriver(), 60)
    rested, _ = stepped(moving.between(None, moving.time), driver, _RESTED)
    paused, _ = stepped(moving.pause(), EchoDriver(sent=list(driver.sent[:60])), _RESTED)
    assert rested.path_velocity == 0.0
    assert rested.time <= paused.time + 1e-9
    assert_kept(driver.sent, motion, limits)


def test_it_does_not_begin_to_move_before_a_barrier_at_its_start() -> None:
    motion = random_motion(1)
    blocked = Execution(motion, tight_limits(motion, 1.1)).between(None, 0.0).start()
    rested, places = stepped(blocked, EchoDriver(), 100)
    assert (rested.state, max(places)) == ("executing", 0.0)
