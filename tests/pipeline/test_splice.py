"""Leaving a running motion: for a stand, or for another motion, without a jump of any rate."""

import time

import numpy as np
import pytest

import planning
from planning.domain.curve import TimedTrajectory
from planning.domain.deadline import Deadline
from planning.domain.motion_state import MotionState
from planning.domain.options import RetimeOptions
from planning.errors import NotCertified, RetimingFailed
from planning.world.world import World
from tests.conftest import bundled_world

OVER = np.array([-0.9, 0.2, -0.3, 0.1, 0.2, 0.4])


def soon() -> Deadline:
    return Deadline.after(30.0, time.monotonic)


def to(world: World, shift: np.ndarray) -> TimedTrajectory:
    home = world.positions(world.group("arm"))
    path = np.stack([home, home + shift])
    options = RetimeOptions(method="ruckig")
    return planning.retime_path(world, "arm", path, deadline=soon(), options=options).trajectory


def goes_on(found: TimedTrajectory, running: TimedTrajectory, at: float) -> None:
    begun, was = MotionState.of(found, 0.0), MotionState.of(running, at)
    np.testing.assert_allclose(begun.q, was.q, atol=1e-9)
    np.testing.assert_allclose(begun.v, was.v, atol=1e-7)
    np.testing.assert_allclose(begun.vdot, was.vdot, atol=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.8, 1.0])
def test_a_stop_goes_on_from_the_state_and_ends_at_rest(pickup: World, share: float) -> None:
    running = to(pickup, OVER)
    at = share * running.duration
    found = planning.stop_motion(pickup, "arm", running, at, deadline=soon())
    goes_on(found.trajectory, running, at)
    assert found.certificate.proven
    assert {"jerk", "rest", "clearance"} <= {check.name for check in found.certificate.checks}
    end = np.array([found.trajectory.duration])
    assert np.abs(found.trajectory.velocities(end)).max() < 1e-6
    # One joint cannot stop sooner than by full braking.
    limits = pickup.limits(pickup.group("arm"))
    state = MotionState.of(running, at)
    assert found.trajectory.duration >= (np.abs(state.v) / limits.acceleration).max() - 1e-6
    assert found.trajectory.duration <= running.duration


def test_a_splice_needs_no_rest_and_ends_where_the_other_motion_does(pickup: World) -> None:
    running, onto = to(pickup, OVER), to(pickup, np.array([-0.6, 0.5, -0.5, 0.2, 0.1, 0.1]))
    at = 0.4 * running.duration
    found = planning.splice_motion(pickup, "arm", running, at, onto, deadline=soon())
    goes_on(found.trajectory, running, at)
    np.testing.assert_allclose(found.trajectory.end, onto.end, atol=1e-6)
    assert found.certificate.proven
    stopped = planning.stop_motion(pickup, "arm", running, at, deadline=soon()).trajectory
    back = planning.retime_path(
        pickup,
        "arm",
        np.stack([stopped.end, onto.start]),
        deadline=soon(),
        options=RetimeOptions(method="ruckig"),
    )
    # Quicker than to stop, to go where the other motion begins, and to follow it from there.
    durations = (stopped.duration, back.trajectory.duration, onto.duration)
    assert found.trajectory.duration < sum(durations)
    # Some last part of the other motion is followed as it is.
    left = np.linspace(0.0, onto.duration / 12, 20)
    followed = found.trajectory.positions(found.trajectory.duration - left)
    np.testing.assert_allclose(followed, onto.positions(onto.duration - left), atol=1e-6)


def test_what_is_left_of_a_motion_is_its_rest(pickup: World) -> None:
    running = to(pickup, OVER)
    for at in (0.0, 0.3 * running.duration, float(running.breaks[2])):
        left = running.after(at)
        times = np.linspace(0.0, running.duration - at, 50)
        assert left.duration == pytest.approx(running.duration - at)
        np.testing.assert_allclose(left.positions(times), running.positions(at + times), atol=1e-9)


def test_what_cannot_be_is_refused_with_reasons(pickup: World) -> None:
    running = to(pickup, OVER)
    with pytest.raises(NotCertified) as refused:
        planning.stop_motion(pickup, "arm", running, 0.4, deadline=soon(), margin=0.5)
    assert {check["name"] for check in refused.value.evidence["checks"]} == {"clearance"}
    world = bundled_world("window_3d")
    q = world.positions(world.group("body"))
    path = np.stack([q, q + np.array([0, 0, 0, 0, 0.01, 0.0, 0.0])])
    turning = planning.retime_path(world, "body", path, deadline=soon()).trajectory
    with pytest.raises(RetimingFailed, match="shift and turn"):
        planning.stop_motion(world, "body", turning, 0.01, deadline=soon())
