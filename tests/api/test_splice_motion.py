"""Leaving a running motion: for a stand, or for another motion, without a jump of any rate."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.motion_state import MotionState
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.errors import NotCertified, ProblemInvalid, RetimingFailed, UnknownName
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world

OVER = np.array([-0.9, 0.2, -0.3, 0.1, 0.2, 0.4])


def soon() -> Deadline:
    return no_hurry(30.0)


def to(world: World, shift: np.ndarray, **limits: Any) -> TimedTrajectory:
    home = world.positions(world.group("arm"))
    path = np.stack([home, home + shift])
    options = RetimeOptions(method="ruckig", **limits)
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
    with pytest.raises(RetimingFailed, match="planar and floating joints"):
        planning.stop_motion(world, "body", turning, 0.01, deadline=soon())


TOOL = "arm::tcp"
# Around the tool where a motion begins, in the tool's own frame.
BOX = planning.PlacedBox(np.full(3, 0.06), reference=TOOL)


def refused(world: World, at: float, **held: Any) -> set[str]:
    """Return the checks that a stop fails, and those that a motion into another one fails."""
    running, onto = to(world, OVER), to(world, np.array([-0.6, 0.5, -0.5, 0.2, 0.1, 0.1]))
    names: list[set[str]] = []
    for others in ((), (onto,)):
        leave = planning.splice_motion if others else planning.stop_motion
        with pytest.raises(NotCertified) as fault:
            leave(world, "arm", running, at, *others, deadline=soon(), **held)
        names.append({check["name"] for check in fault.value.evidence["checks"]})
    assert all(one & other for one, other in pairwise(names))
    return set.intersection(*names)


def test_whoever_leaves_a_motion_keeps_what_is_asked_of_it(pickup: World) -> None:
    """All this would be broken; nothing of it is seen unless it is told."""
    kept = planning.RetimeOptions
    slow = kept(tool_limits=(planning.ToolLimit(TOOL, 0.01),))
    assert "tool_speed arm::tcp" in refused(pickup, 0.4, options=slow)
    assert "torque" in refused(
        pickup, 0.4, options=kept(effort=True, payload=planning.Payload(TOOL, 60.0))
    )
    assert "clearance" in refused(pickup, 0.4, margin=0.5)
    locked = (planning.LockedJoints(("arm::elbow_joint",)),)
    assert "constraint 0: locked_joints" in refused(pickup, 0.4, constraints=locked)


def test_the_start_is_where_the_motion_began_that_is_left(pickup: World) -> None:
    running = to(pickup, OVER)
    zone = planning.SpeedZone("start", TOOL, BOX, 0.001)
    soon_after, later = 0.15, 0.7 * running.duration
    assert "speed_zone start" in refused(
        pickup, soon_after, options=planning.RetimeOptions(speed_zones=(zone,))
    )
    assert "constraint 0: keep_in" in refused(
        pickup, later, constraints=(planning.KeepIn(TOOL, BOX),)
    )
    # Far from where it began the tool is out of that box, and as quick as it likes.
    found = planning.stop_motion(
        pickup,
        "arm",
        running,
        later,
        deadline=soon(),
        options=planning.RetimeOptions(speed_zones=(zone,)),
        constraints=(planning.KeepOut(TOOL, BOX),),
    )
    names = {check.name for check in found.certificate.checks}
    assert {"speed_zone start", "constraint 0: keep_out"} <= names


def test_scales_and_bounds_by_sign_are_kept_on_the_way(pickup: World) -> None:
    bounds = {"arm::shoulder_pan_joint": (-0.8, 0.8), "arm::elbow_joint": (-0.4, 0.9)}
    limits = {"velocity_scale": 0.6, "acceleration_scale": 0.7, "acceleration_bounds": bounds}
    running = to(pickup, OVER, **limits)
    at = 0.4 * running.duration
    held = {"deadline": soon(), "options": RetimeOptions(**limits)}
    stopped = planning.stop_motion(pickup, "arm", running, at, **held)
    spliced = planning.splice_motion(pickup, "arm", running, at, running, **held)
    for found in (stopped.trajectory, spliced.trajectory):
        goes_on(found, running, at)
        rates = found.accelerations(np.linspace(0.0, found.duration, 999))[:, [0, 2]] * 0.999
        assert (rates > [low for low, _ in bounds.values()]).all()
        assert (rates < [high for _, high in bounds.values()]).all()
    quicker = planning.stop_motion(pickup, "arm", running, at, deadline=soon())
    assert quicker.trajectory.duration < stopped.trajectory.duration


def test_what_makes_no_sense_is_said(pickup: World) -> None:
    running, panda = to(pickup, OVER), bundled_world("panda_shelf")
    nobody = (planning.KeepIn("arm::nobody", BOX),)
    with pytest.raises(UnknownName, match="nobody"):
        planning.stop_motion(pickup, "arm", running, 0.4, deadline=soon(), constraints=nobody)
    with pytest.raises(ProblemInvalid, match="running"):
        planning.stop_motion(panda, "panda", running, 0.4, deadline=soon())
    other = TimedTrajectory(
        panda.group("panda").joints, np.array([0.0, 1.0]), np.zeros((1, 7)), np.zeros((1, 1, 7))
    )
    with pytest.raises(ProblemInvalid, match="onto"):
        planning.splice_motion(pickup, "arm", running, 0.4, other, deadline=soon())
