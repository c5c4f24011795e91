"""Stops along the path of a running motion: on it, from its state, quick and certified."""

from itertools import product
from typing import Any, Literal

import numpy as np
import pytest

import planning
from planning.api.splice_motion import ProvenMotion
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.motion_state import MotionState
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.errors import NotCertified
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

CORNER = np.array([[0.0] * 6, [-0.9, 0.2, -0.3, 0.1, 0.2, 0.4], [-1.2, 0.2, -0.1, 0.3, 0.2, 0.4]])
TOOL = planning.ToolLimit("arm::tcp", None, 2.0)
LIMITS: dict[str, dict[str, Any]] = {
    "joints": {},
    "tool": {"tool_limits": (TOOL,)},
    "effort": {"effort": True, "payload": planning.Payload("arm::tcp", 2.0)},
    "sign": {"acceleration_bounds": {"arm::shoulder_pan_joint": (-1.5, 3.0)}},
}
METHODS: tuple[Literal["toppra", "ruckig"], ...] = ("toppra", "ruckig")


def soon() -> Deadline:
    return no_hurry(30.0)


def run(world: World, options: RetimeOptions) -> TimedTrajectory:
    path = world.positions(world.group("arm")) + CORNER
    return planning.retime_path(world, "arm", path, deadline=soon(), options=options).trajectory


def stopped(
    world: World, running: TimedTrajectory, at: float, options: RetimeOptions | None
) -> ProvenMotion:
    return planning.stop_motion(
        world, "arm", running, at, deadline=soon(), options=options, along_path=True
    )


def off_the_path(found: TimedTrajectory, running: TimedTrajectory, at: float) -> float:
    """Return how far samples of a motion are from the rest of another one, which it follows.

    Its place on that is looked for by bisection of the way that the first joint has gone.
    """
    q = found.positions(np.linspace(0.0, found.duration, 60))
    low, high = np.full(len(q), at), np.full(len(q), running.duration)
    sign = np.sign(running.end[0] - running.start[0])
    for _ in range(60):
        middle = (low + high) / 2
        is_before = sign * running.positions(middle)[:, 0] < sign * q[:, 0]
        low, high = np.where(is_before, middle, low), np.where(is_before, high, middle)
    return float(np.abs(running.positions((low + high) / 2) - q).max())


# With two more of the last in a campaign.
CASES = [
    *product(("toppra",), LIMITS),
    *product(("ruckig",), ("joints", "sign", "tool", "effort")[: num_cases(2, 4)]),
]


@pytest.mark.campaign
@pytest.mark.parametrize(("method", "limits"), CASES)
def test_a_stop_along_the_path_stays_on_it_and_keeps_what_the_motion_keeps(
    pickup: World, method: Literal["toppra", "ruckig"], limits: str
) -> None:
    options = RetimeOptions(method=method, **LIMITS[limits])
    running = run(pickup, options)
    for share in (0.15, 0.5, 0.8):
        at = share * running.duration
        found = stopped(pickup, running, at, options)
        motion, left = found.trajectory, running.duration - at
        assert found.certificate.proven
        names = {check.name for check in found.certificate.checks}
        assert ("jerk" in names) == (method == "ruckig")
        begun, was = MotionState.of(motion, 0.0), MotionState.of(running, at)
        np.testing.assert_allclose(begun.q, was.q, atol=1e-8)
        np.testing.assert_allclose(begun.v, was.v, atol=1e-6)
        if method == "ruckig":
            np.testing.assert_allclose(begun.vdot, was.vdot, atol=1e-5)
        np.testing.assert_allclose(MotionState.of(motion, motion.duration).v, 0.0, atol=1e-6)
        assert off_the_path(motion, running, at) < 1e-7
        assert motion.duration <= left + 1e-9
        if share == (0.5 if method == "toppra" else 0.15):
            # Sooner over than the motion would be; at full speed limits on jerk leave nothing.
            assert motion.duration < 0.9 * left


def test_what_limits_a_motion_makes_its_stops_longer(pickup: World) -> None:
    running = run(pickup, RetimeOptions(**LIMITS["tool"]))
    at = 0.5 * running.duration
    free = stopped(pickup, running, at, RetimeOptions())
    held = stopped(pickup, running, at, RetimeOptions(**LIMITS["tool"]))
    assert free.trajectory.duration < 0.8 * held.trajectory.duration


def test_one_joint_stops_as_quickly_as_it_can(pickup: World) -> None:
    home = pickup.positions(pickup.group("arm"))
    limits = pickup.limits(pickup.group("arm"))
    for method, bound in zip(METHODS, (1.01, 1.25), strict=True):
        options = RetimeOptions(method=method)
        path = np.stack([home, home + np.array([-1.5, 0, 0, 0, 0, 0])])
        running = planning.retime_path(
            pickup, "arm", path, deadline=soon(), options=options
        ).trajectory
        at = running.duration / 2
        speed = float(np.abs(running.velocities(np.array([at]))).max())
        best = speed / limits.acceleration[0]
        if method == "ruckig":
            best += limits.acceleration[0] / limits.jerk[0]
        assert best - 1e-6 <= stopped(pickup, running, at, options).trajectory.duration
        assert stopped(pickup, running, at, options).trajectory.duration <= bound * best + 0.02


def test_a_motion_with_jumps_cannot_be_stopped_without(pickup: World) -> None:
    running = run(pickup, RetimeOptions())
    with pytest.raises(NotCertified) as refused:
        stopped(pickup, running, 0.3 * running.duration, None)
    failed = {check["name"] for check in refused.value.evidence["checks"]}
    assert failed & {"jerk", "acceleration continuity"}
    assert "clearance" not in failed


def test_the_ends_of_a_motion_are_instants_too(pickup: World) -> None:
    for method in METHODS:
        options = RetimeOptions(method=method)
        running = run(pickup, options)
        for at in (0.0, float(running.breaks[2]), running.duration):
            found = stopped(pickup, running, at, options).trajectory
            np.testing.assert_allclose(found.start, MotionState.of(running, at).q, atol=1e-8)
            assert found.duration <= running.duration - at + 1e-8


@pytest.mark.parametrize("method", METHODS)
def test_bodies_that_float_stop_along_their_path(method: Literal["toppra", "ruckig"]) -> None:
    world = bundled_world("window_3d")
    q = world.positions(world.group("body"))
    turned = np.array([0.99, 0.1, -0.05, 0.02, 0, 0.05, 0.02])
    turned[:4] /= np.linalg.norm(turned[:4])
    turned[4:] += q[4:]
    options = RetimeOptions(method=method)
    running = planning.retime_path(
        world, "body", np.stack([q, turned]), deadline=soon(), options=options
    ).trajectory
    at = 0.5 * running.duration
    found = planning.stop_motion(
        world, "body", running, at, deadline=soon(), options=options, along_path=True
    )
    assert found.certificate.proven
    assert found.trajectory.duration <= running.duration - at + 1e-9
    np.testing.assert_allclose(found.trajectory.start, MotionState.of(running, at).q, atol=1e-8)
