"""What every driver promises (`planning.execute.driver.Driver`), as tests of a rig.

For a robot of your own: make a class `TestMine(DriverContract)` with a fixture `rig` that returns a
`DriverRig` of it, here or in a test folder of yours. The robot moves: give it room.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.errors import DriverLost
from planning.execute.driver import Driver, Measurement, Setpoint
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from tests.profiles import only_campaign


@dataclass(frozen=True)
class DriverRig:
    """A driver of a robot at rest, and a short motion that it can follow.

    Attributes:
        driver: That is not started.
        motion: From where the robot is, from rest to rest.
        limits: Of the robot.
        lose: Breaks the connection to the robot.
        tracking: How far it may be from its setpoints [rad or m].
        rate_tracking: How far its velocity may be from theirs [rad/s or m/s].
        clock: Of the caller [s]: real time for a robot; None if the driver's may be any.
    """

    driver: Driver
    motion: TimedTrajectory
    limits: JointLimits
    lose: Callable[[], Any]
    tracking: float
    rate_tracking: float
    clock: Callable[[], float] | None = None


def setpoint_at(motion: TimedTrajectory, time: float, place: float) -> Setpoint:
    """Return the setpoint of a place on a motion [s], at a time of the driver's clock."""
    at = np.array([min(place, motion.duration)])
    moves = 0.0 if place >= motion.duration else 1.0
    v, vdot = motion.velocities(at)[0], motion.accelerations(at)[0]
    return Setpoint(time, motion.positions(at)[0], moves * v, moves * vdot)


class DriverContract:
    """Tests of a fixture `rig`."""

    def test_it_says_what_it_is(self, rig: DriverRig) -> None:
        traits = rig.driver.traits
        assert isinstance(rig.driver, Driver)
        assert traits.name
        assert 0 < traits.period <= 0.1
        assert traits.max_realtime_factor >= 1

    def test_it_starts_at_rest_where_the_robot_is(self, rig: DriverRig) -> None:
        first = rig.driver.start()
        self._check_shapes(first, rig)
        assert 0 <= first.time <= rig.driver.traits.period
        assert self._distance(rig, first.q, rig.motion.start) <= rig.tracking
        assert np.abs(first.v).max() <= rig.rate_tracking
        rig.driver.stop()

    def test_it_rests_while_it_is_told_to(self, rig: DriverRig) -> None:
        for measured, _ in self._followed(rig, 20, rate=0.0):
            assert self._distance(rig, measured.q, rig.motion.start) <= rig.tracking
            assert np.abs(measured.v).max() <= rig.rate_tracking
        rig.driver.stop()

    def test_it_follows_what_keeps_its_limits(self, rig: DriverRig) -> None:
        steps = int(rig.motion.duration / rig.driver.traits.period) + 50
        last = 0.0
        for measured, asked in self._followed(rig, steps):
            self._check_shapes(measured, rig)
            assert not measured.contacts
            assert measured.time > last
            last = measured.time
            assert self._distance(rig, measured.q, asked.q) <= rig.tracking
            assert np.abs(measured.v - asked.v).max() <= rig.rate_tracking
        assert self._distance(rig, measured.q, rig.motion.end) <= rig.tracking
        rig.driver.stop()

    def test_a_measurement_is_not_older_than_asked_for(self, rig: DriverRig) -> None:
        measured, period = rig.driver.start(), rig.driver.traits.period
        for _ in range(10):
            rig.driver.send(setpoint_at(rig.motion, measured.time, 0.0))
            asked = measured.time + period
            measured = rig.driver.read(asked)
            assert asked - 0.5 * period <= measured.time <= asked + 10 * period
        rig.driver.stop()

    def test_an_execution_succeeds(self, rig: DriverRig) -> None:
        runner = Runner(Execution(rig.motion, rig.limits), rig.driver)
        self._run(rig, runner)
        assert runner.status.failure is None
        assert runner.status.state == "succeeded"
        assert self._distance(rig, runner.status.measured, rig.motion.end) <= 5e-3
        runner.stop()

    def test_a_canceled_execution_rests_on_its_path(self, rig: DriverRig) -> None:
        runner = Runner(Execution(rig.motion, rig.limits), rig.driver)
        self._run(rig, runner, until=0.5, then=runner.cancel)
        assert runner.status.state == "canceled"
        assert 0 < runner.status.progress < 1
        assert np.abs(runner.status.velocities).max() <= 0.01
        assert runner.status.tracking_error <= rig.tracking
        runner.stop()

    @only_campaign("20 s for all drivers and robots")
    def test_one_that_goes_back_is_where_it_began(self, rig: DriverRig) -> None:
        runner = Runner(Execution(rig.motion, rig.limits), rig.driver)
        self._run(rig, runner, until=0.5, then=lambda: runner.set_speed(-1.0), limit=400)
        assert runner.status.state == "executing"
        assert (runner.status.time, runner.status.path_velocity) == (0.0, 0.0)
        assert self._distance(rig, runner.status.measured, rig.motion.start) <= 5e-3
        runner.stop()

    def test_after_a_stop_it_obeys_no_more(self, rig: DriverRig) -> None:
        measured = rig.driver.start()
        rig.driver.stop()
        rig.driver.stop()
        for call in (
            lambda: rig.driver.send(setpoint_at(rig.motion, 0.0, 0.0)),
            lambda: rig.driver.read(measured.time + 0.1),
        ):
            with pytest.raises(DriverLost) as lost:
                call()
            evidence = lost.value.evidence
            assert evidence["driver"] == rig.driver.traits.name
            assert evidence["reason"]

    def test_one_that_is_lost_aborts_and_says_whether_it_rests(self, rig: DriverRig) -> None:
        runner = Runner(Execution(rig.motion, rig.limits), rig.driver)
        self._run(rig, runner, until=0.5, then=rig.lose, limit=400)
        assert runner.status.state == "aborted"
        assert isinstance(runner.status.failure, DriverLost)
        rests = runner.status.failure.evidence["rests"]
        assert rests == rig.driver.traits.rests_when_lost
        runner.stop()

    def _followed(self, rig: DriverRig, steps: int, rate: float = 1.0) -> Any:
        """Yield measurements, and the setpoints at their instants."""
        measured, period = rig.driver.start(), rig.driver.traits.period
        begin = measured.time
        for _ in range(steps):
            place = rate * (measured.time - begin)
            rig.driver.send(setpoint_at(rig.motion, measured.time, place))
            measured = rig.driver.read(measured.time + period)
            asked = setpoint_at(rig.motion, measured.time, rate * (measured.time - begin))
            yield measured, asked

    def _run(
        self,
        rig: DriverRig,
        runner: Runner,
        until: float | None = None,
        then: Callable[[], Any] = lambda: None,
        limit: int = 2000,
    ) -> None:
        """Run until the end, or some ticks more after half of the way and what is done then."""
        period = rig.driver.traits.period
        now = 0.0 if rig.clock is None else rig.clock()
        runner.start(now)
        is_done = until is None
        for _ in range(int(rig.motion.duration / period) + limit):
            now = now + period if rig.clock is None else rig.clock()
            runner.tick(now)
            if runner.is_done:
                return
            if not is_done and until is not None and runner.status.progress >= until:
                is_done = True
                then()

    def _check_shapes(self, measured: Measurement, rig: DriverRig) -> None:
        count = rig.motion.manifold.num_velocities
        assert measured.q.shape == rig.motion.start.shape
        assert measured.v.shape == (count,)
        assert np.isfinite(measured.q).all()
        if measured.torques is not None:
            assert measured.torques.shape == (count,)
            assert np.isfinite(measured.torques).all()

    def _distance(self, rig: DriverRig, q: np.ndarray, other: np.ndarray) -> float:
        return float(np.abs(rig.motion.manifold.minus(q, other)).max())
