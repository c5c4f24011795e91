"""Control loop of an execution, on a clock that the test sets."""

from typing import Any

import numpy as np
import pytest

from planning.errors import IllegalTransition, ProblemInvalid, TrackingLost
from planning.execute.execution import Execution
from planning.execute.runner import Runner


def run(runner: Runner, now: float = 0.0, until: float = 20.0, period: float = 0.05) -> float:
    """Tick until it is done and return when that was."""
    while not runner.is_done and now < until:
        now += period
        runner.tick(now)
    return now


def test_it_reports_rising_progress(execution: Execution, new_driver: Any) -> None:
    runner = Runner(execution, new_driver())
    assert runner.tick(-1.0).state == "accepted"
    assert runner.start(0.0).state == "executing"
    statuses = [runner.tick(0.05 * i) for i in range(60)]
    progress = [status.progress for status in statuses]
    assert progress == sorted(progress)
    assert (progress[0], progress[-1], statuses[-1].state) == (0.0, 1.0, "succeeded")
    middle = statuses[20]
    assert middle.time == pytest.approx(1.0, abs=0.005)
    assert middle.driver_time == pytest.approx(1.0, abs=0.005)
    np.testing.assert_allclose(middle.measured, middle.desired, atol=1e-6)
    assert middle.tracking_error == np.max(np.abs(middle.measured - middle.desired))


@pytest.mark.parametrize(("speed", "duration"), [(0.5, 4.0), (1.0, 2.0), (4.0, 0.5), (20.0, 0.1)])
def test_speed_is_seconds_of_trajectory_per_second(
    execution: Execution, new_driver: Any, speed: float, duration: float
) -> None:
    runner = Runner(execution, new_driver())
    runner.set_speed(speed)
    runner.start(100.0)
    assert run(runner, 100.0, 120.0, 0.01) - 100.0 == pytest.approx(duration, abs=0.03)
    assert runner.status.state == "succeeded"
    # beyond 1 the robot's own clock runs fast and its motion stays as it is
    assert runner.status.driver_time == pytest.approx(max(2.0, duration), abs=0.03)


def test_a_late_tick_does_not_work_for_long(execution: Execution, new_driver: Any) -> None:
    driver = new_driver()
    runner = Runner(execution, driver, max_catch_up=0.2)
    runner.start(0.0)
    runner.tick(3600.0)
    assert len(driver.sent) == 50
    assert runner.status.driver_time == pytest.approx(0.2)


def test_pause_resume_and_cancel(execution: Execution, new_driver: Any) -> None:
    runner = Runner(execution, new_driver())
    with pytest.raises(IllegalTransition):
        runner.pause()
    runner.start(0.0)
    run(runner, 0.0, 1.0)
    assert runner.pause().state == "paused"
    run(runner, 1.0, 5.0)
    paused = runner.status
    assert paused.path_velocity == 0.0
    assert paused.progress < 0.75
    assert runner.resume().state == "executing"
    run(runner, 5.0, 5.2)
    assert runner.status.progress > paused.progress
    assert runner.cancel().state == "canceling"
    run(runner, 5.2, 10.0)
    assert runner.status.state == "canceled"
    with pytest.raises(IllegalTransition):
        runner.cancel()


def test_a_contact_stays_in_the_last_status(execution: Execution, new_driver: Any) -> None:
    runner = Runner(execution, new_driver(touches_at=0.5))
    runner.start(0.0)
    run(runner)
    assert runner.status.state == "aborted"
    assert runner.status.contacts[0].bodies == ("arm::link", "wall")
    assert runner.status.failure is not None
    assert runner.status.failure.code == "contact"


def test_a_driver_that_fails_aborts(execution: Execution, new_driver: Any) -> None:
    driver = new_driver()
    runner = Runner(execution, driver)
    runner.start(0.0)

    def fail(_: float) -> None:
        raise TrackingLost("the simulation diverged")

    driver.read = fail
    assert runner.tick(0.1).state == "aborted"
    assert runner.status.failure is not None
    assert runner.status.failure.detail == "the simulation diverged"


@pytest.mark.parametrize("speed", [-1000.0, 1000.0, float("nan")])
def test_impossible_speeds_are_refused(execution: Execution, new_driver: Any, speed: float) -> None:
    with pytest.raises(ProblemInvalid, match="speed"):
        Runner(execution, new_driver()).set_speed(speed)


def test_a_robot_has_no_faster_clock(execution: Execution, new_driver: Any) -> None:
    for speed in (1.5, -1.5):
        with pytest.raises(ProblemInvalid, match="at most 1"):
            Runner(execution, new_driver(max_realtime_factor=1.0)).set_speed(speed)
