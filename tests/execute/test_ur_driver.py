"""The driver of Universal Robots against a stand-in for the protocol on loopback."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointLimits, JointType
from planning.errors import DriverLost
from planning.execute.driver import Setpoint
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from planning.execute.ur.rtde_package import PackageReader, PackageType, encode
from planning.execute.ur.servo_deviation import servo_deviation
from planning.execute.ur.servo_program import ServoOptions, servo_program
from planning.execute.ur.ur_driver import UrAddress, UrDriver
from tests.contracts.rtde_stub import PERIOD, RtdeStub
from tests.profiles import num_cases

JOINTS = tuple(Joint(f"arm::j{i}", JointType.REVOLUTE) for i in range(6))
HOME = [0.0, -1.5, 1.5, -1.5, -1.5, 0.0]


def motion() -> TimedTrajectory:
    coefficients = np.zeros((1, 6, 6))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[0, power] = factor * np.array([0.3, -0.2, 0.1, 0.4, 0.0, -0.3])
    return TimedTrajectory(JOINTS, np.array([0.0, 1.0]), np.array([HOME]), coefficients)


def limits(acceleration: float = 5.0) -> JointLimits:
    six, none = np.ones(6), np.full(6, np.inf)
    blocks = tuple((i,) for i in range(6))
    return JointLimits(-9 * six, 9 * six, 3 * six, acceleration * six, none, none, blocks)


@pytest.fixture
def stub() -> Iterator[RtdeStub]:
    controller = RtdeStub(HOME)
    yield controller
    controller.close()


def driver_of(stub: RtdeStub, timeout: float = 60.0) -> UrDriver:
    return UrDriver(UrAddress("127.0.0.1", *stub.ports, timeout=timeout))


def test_what_is_sent_is_the_certified_polynomial_at_the_controllers_rate(stub: RtdeStub) -> None:
    trajectory = motion()
    runner = Runner(Execution(trajectory, limits()), driver_of(stub))
    runner.start(0.0)
    for i in range(400):
        runner.tick(PERIOD * (i + 1))
        if runner.is_done:
            break
    runner.stop()
    assert runner.status.state == "succeeded"
    sent = np.array(stub.targets[: int(1.0 / PERIOD)])
    # a target is where the polynomial is a period later: constant vdot until then is off by h^3 / 6
    # of a jerk of 60 * 0.4
    expected = trajectory.positions(PERIOD * (1 + np.arange(len(sent))))
    np.testing.assert_allclose(sent, expected, atol=1.01 * PERIOD**3 / 6 * 24)
    assert runner.status.torques is None


def test_the_program_follows_registers_under_a_watchdog(stub: RtdeStub) -> None:
    driver = driver_of(stub)
    driver.start()
    assert stub.program == servo_program(ServoOptions())
    driver.stop()
    for part in ('rtde_set_watchdog("input_int_register_24", 10, "stop")', "t=0.008", "stopj(4)"):
        assert part in stub.program
    reads = [f"read_input_float_register({i})" for i in range(24, 30)]
    assert ", ".join(reads) in stub.program


def test_of_many_measurements_the_newest_counts(stub: RtdeStub) -> None:
    driver = driver_of(stub)
    first = driver.start()
    stub.burst = 5
    stub.cycled.clear()
    driver.send(_hold(first.time))
    assert stub.cycled.wait(60)
    assert driver.read(first.time + PERIOD).time == pytest.approx(5 * PERIOD)
    driver.stop()


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"taken": {"input_double_register_26"}}, "input_double_register_26 (IN_USE)"),
        ({"version_accepted": 0}, "refused REQUEST_PROTOCOL_VERSION"),
        ({"safety_mode": 3}, "safety mode is 3"),
        ({"qd": [0.2] * 6}, "moves already"),
        ({"runs_programs": False}, "remote control"),
    ],
)
def test_a_controller_that_is_not_ready_is_lost_at_once(
    stub: RtdeStub, wrong: dict[str, Any], reason: str
) -> None:
    for name, value in wrong.items():
        setattr(stub, name, value)
    timeout = 0.02 if "runs_programs" in wrong else 60.0
    with pytest.raises(DriverLost) as lost:
        driver_of(stub, timeout).start()
    assert reason in lost.value.evidence["reason"] or "silent" in lost.value.evidence["reason"]
    assert lost.value.evidence["rests"] is False


@pytest.mark.parametrize(
    ("change", "reason"),
    [({"safety_mode": 3}, "safety mode is 3"), ({"runtime_state": 1}, "program has ended")],
)
def test_one_that_stops_by_itself_is_lost(
    stub: RtdeStub, change: dict[str, Any], reason: str
) -> None:
    driver = driver_of(stub)
    first = driver.start()
    for name, value in change.items():
        setattr(stub, name, value)
    driver.send(_hold(first.time))
    with pytest.raises(DriverLost, match=reason):
        driver.read(first.time + PERIOD)
    with pytest.raises(DriverLost, match="stopped"):
        driver.read(first.time + 2 * PERIOD)


def test_a_controller_that_is_not_there_is_lost(stub: RtdeStub) -> None:
    ports = stub.ports
    driver = UrDriver(UrAddress("127.0.0.1", ports[1], ports[1], timeout=0.1))
    with pytest.raises(DriverLost, match=r"silent|closed|broke"):
        driver.start()


def test_packages_are_cut_from_a_stream_however_it_comes() -> None:
    stream = b"".join(encode(PackageType.DATA, bytes([i]) * i) for i in range(5))
    reader, found = PackageReader(), list[tuple[int, bytes]]()
    for byte in stream:
        reader.feed(bytes([byte]))
        while (package := reader.next()) is not None:
            found.append(package)
    assert found == [(PackageType.DATA, bytes([i]) * i) for i in range(5)]
    reader.feed(b"\x00\x02U")
    with pytest.raises(ValueError, match="shorter"):
        reader.next()


@settings(max_examples=num_cases(20))
@given(st.integers(0, 10_000), st.integers(1, 12))
def test_smoothed_samples_stay_within_the_deviation(seed: int, window: int) -> None:
    """Any average of the samples in the window, of a random motion with bounded acceleration."""
    rng = np.random.default_rng(seed)
    bound, fine = 5.0, 40
    options = ServoOptions(lookahead=window * PERIOD)
    step = PERIOD / fine
    vdot = bound * np.sign(rng.normal(size=600 * fine // 40).repeat(40))
    v = np.cumsum(vdot) * step
    q = np.cumsum(v - 0.5 * vdot * step) * step
    times = step * np.arange(len(q))
    sampled = np.interp(times, times[::fine], q[::fine])
    weights = rng.dirichlet(np.full(window + 1, 0.3))
    delays = fine * np.arange(window + 1)
    mean = float(weights @ delays) * step
    at = np.arange(delays[-1], len(q) - fine)
    smoothed = sum(w * sampled[at - d] for w, d in zip(weights, delays, strict=True))
    off = np.abs(smoothed - np.interp(times[at] - mean, times, q))
    (allowed, *_) = servo_deviation(limits(bound), options)
    assert off.max() <= allowed * (1 + 1e-6) + 1e-9


def test_the_deviation_is_reached() -> None:
    """Half of the first and half of the last sample of the window, at constant acceleration."""
    options, bound = ServoOptions(lookahead=0.04), 5.0
    t, window = 1.0, options.lookahead
    ends = 0.5 * bound * np.array([t, t - window]) ** 2
    off = ends.mean() - 0.5 * bound * (t - window / 2) ** 2
    (allowed, *_) = servo_deviation(limits(bound), options)
    assert off == pytest.approx(allowed - bound * options.period**2 / 8)


def _hold(time: float) -> Any:

    return Setpoint(time, np.array(HOME), np.zeros(6), np.zeros(6))
