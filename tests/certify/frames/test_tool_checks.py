"""Speeds and accelerations of frames: the values of the checks hold at every instant."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform

from planning.certify.certifier import CertifyRequest
from planning.certify.frames.frame_derivative_bounds import origin_bounds
from planning.certify.frames.frame_states import FrameStates
from planning.certify.frames.tool_checks import tool_checks
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.geometry.pose import Pose
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import PlacedBox
from planning.domain.request.motion_limits import SpeedZone, ToolLimit
from planning.domain.robot.joints import JointType
from planning.world.collision.margins import PairMargins
from planning.world.world import World
from tests.certify.chains import Builder, random_trajectory
from tests.certify.conftest import certificate_of, quintic, request_for
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

MOVERS = [
    ("ur5e_pickup", "arm", "arm::tcp"),
    ("panda_shelf", "panda", "panda::panda_hand_tcp"),
    ("window_3d", "body", "body::body"),
    ("maze_2d", "body", "body::body"),
]


def checks_of(world: World, request: CertifyRequest) -> dict[str, Check]:
    deadline = no_hurry(30)
    return {check.name: check for check in tool_checks(world.drake, request, deadline)}


def moving(scene: str, name: str, seed: int) -> tuple[World, CertifyRequest]:
    """Return a wild motion in pieces of degree five, near where the group is."""
    world = bundled_world(scene)
    group = world.group(name)
    rng = np.random.default_rng(seed)
    motion = random_trajectory(rng, group, 2, 0.3)
    return world, request_for(world, name, motion)


def positions(world: World, request: CertifyRequest, frame: str, times: np.ndarray) -> np.ndarray:
    full = world.embed(request.group, request.trajectory.positions(times))
    return world.frame_poses(frame, full)[:, :3, 3]


@pytest.mark.parametrize(("scene", "name", "frame"), MOVERS)
@given(seed=st.integers(0, 200))
@settings(max_examples=num_cases(2))
def test_values_bound_the_peaks_and_are_hardly_more(
    scene: str, name: str, frame: str, seed: int
) -> None:
    world, request = moving(scene, name, seed)
    limited = replace(request, tool_limits=(ToolLimit(frame, 50.0, 500.0),))
    found = checks_of(world, limited)
    times = np.linspace(0, request.trajectory.duration, 4000)
    p = positions(world, request, frame, times)
    speeds = np.linalg.norm(np.diff(p, axis=0), axis=1) / times[1]
    changes = np.linalg.norm(np.diff(p, 2, axis=0), axis=1) / times[1] ** 2
    speed, acceleration = (found[f"{kind} {frame}"] for kind in ("tool_speed", "tool_acceleration"))
    assert speeds.max() <= speed.value <= 1.003 * speeds.max() + 0.5
    assert changes.max() <= 1.001 * acceleration.value
    assert acceleration.value <= 1.01 * changes.max() + 5
    assert speed.passed == (speed.value <= 50)


@pytest.mark.parametrize(("scene", "name", "frame"), MOVERS)
@given(seed=st.integers(0, 1000))
@settings(max_examples=num_cases(4))
def test_bounds_on_derivatives_hold_at_every_instant(
    scene: str, name: str, frame: str, seed: int
) -> None:
    world, request = moving(scene, name, seed)
    bounds = origin_bounds(world.drake, request, frame).derivatives
    breaks = request.trajectory.breaks
    for piece, (begin, end) in enumerate(pairwise(breaks)):
        h = (end - begin) / 200
        p = positions(world, request, frame, begin + h * np.arange(201))
        for order in range(1, 5):
            # A difference of some order is a derivative of that order somewhere in between.
            seen = np.linalg.norm(np.diff(p, order, axis=0), axis=1).max() / h**order
            assert seen <= bounds[piece, order - 1] * (1 + 1e-6) + 1e-6


@given(rate=st.floats(0.1, 5.0), arm=st.floats(0.05, 1.0))
@settings(max_examples=num_cases(5))
def test_bounds_of_one_arm_at_constant_rate_are_exact(rate: float, arm: float) -> None:
    """|p^(m)| = rate^m arm."""
    builder = Builder()
    builder.link(JointType.REVOLUTE, Sphere(0.1), x_bm=RigidTransform(np.array([arm, 0, 0])))
    robot = builder.build()
    body = robot.model.plant.get_body(robot.model.bodies["robot::link0"])
    model = replace(robot.model, frames={"tip": body.body_frame()})
    coefficients = np.array([[[0.0], [rate]]])
    motion = TimedTrajectory(
        robot.group.joints, np.array([0.0, 1.0]), np.zeros((1, 1)), coefficients
    )
    margins = PairMargins(0.0, {}, {})
    found = origin_bounds(model, robot.request(motion, margins), "tip").derivatives
    np.testing.assert_allclose(found[0], arm * rate ** np.arange(1.0, 5.0), rtol=1e-9)


@pytest.mark.parametrize("size", [1e30, 1e100, 1e200])
def test_huge_motions_are_refused_without_an_error(size: float) -> None:
    world, request = moving("ur5e_pickup", "arm", 3)
    motion = replace(request.trajectory, coefficients=request.trajectory.coefficients * size)
    limited = replace(
        request,
        trajectory=motion,
        tool_limits=(ToolLimit("arm::tcp", 1.0, 1.0),),
        speed_zones=(SpeedZone("slow", "arm::tcp", PlacedBox(np.full(3, 9.0)), 1.0),),
    )
    assert not any(check.passed for check in checks_of(world, limited).values())


def test_states_are_the_derivatives_of_positions() -> None:
    world, request = moving("panda_shelf", "panda", 3)
    states = FrameStates(world.drake, request, "panda::panda_hand_tcp")
    deadline = no_hurry(30)
    h, t = 1e-4, 0.1
    seen = states.at(np.zeros(3, dtype=int), np.array([t - h, t, t + h]), deadline)
    np.testing.assert_allclose(
        seen.velocity[1], (seen.position[2] - seen.position[0]) / (2 * h), atol=1e-5
    )
    np.testing.assert_allclose(
        seen.acceleration[1], (seen.velocity[2] - seen.velocity[0]) / (2 * h), atol=1e-3
    )


def straight(length: float, duration: float) -> tuple[World, CertifyRequest]:
    """Return a body that floats along x: by its centre, 30 / 16 length / duration at most."""
    world = bundled_world("window_3d")
    group = world.group("body")
    assert group.joints[0].type is JointType.FLOATING
    q0 = world.positions(group)
    q1 = np.array(q0)
    q1[4] += length
    return world, request_for(world, "body", quintic(group, q0, q1, duration))


def test_a_straight_motion_has_the_speed_of_its_polynomial() -> None:
    world, request = straight(0.4, 2.0)
    peak = 30 / 16 * 0.4 / 2.0
    for limit, passes in ((peak * 1.001, True), (peak * 0.999, False)):
        limited = replace(request, tool_limits=(ToolLimit("body::body", limit),))
        check = checks_of(world, limited)["tool_speed body::body"]
        assert check.passed is passes
        assert check.value == pytest.approx(peak, rel=2e-3)
        assert check.time == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("where", "passes"), [(0.0, True), (0.5, False), (1.0, True)])
def test_a_zone_counts_only_while_the_origin_is_in_it(where: float, passes: bool) -> None:
    """The motion is slow near its ends and fast in the middle."""
    world, request = straight(0.4, 2.0)
    q = request.trajectory.positions(np.array([2.0 * where]))[0]
    box = PlacedBox(np.array([0.02, 0.02, 0.02]), Pose.from_parts(q[4:]))
    zone = SpeedZone("slow", "body::body", box, 0.2)
    limited = replace(request, speed_zones=(zone,))
    check = checks_of(world, limited)["speed_zone slow"]
    assert check.passed is passes
    certificate = certificate_of(world, limited)
    assert ("speed_zone slow" in [failed.name for failed in certificate.failed]) is not passes


def test_a_zone_that_is_only_grazed_does_not_count() -> None:
    world, request = straight(0.4, 2.0)
    middle = request.trajectory.positions(np.array([1.0]))[0][4:]
    beside = middle + np.array([0.0, 0.0105, 0.0])
    box = PlacedBox(np.array([0.02, 0.02, 0.02]), Pose.from_parts(beside))
    limited = replace(request, speed_zones=(SpeedZone("slow", "body::body", box, 0.01),))
    assert checks_of(world, limited)["speed_zone slow"].passed


def test_acceleration_bounds_count_by_sign() -> None:
    """A joint by 10 x^3 - 15 x^4 + 6 x^5 speeds up and slows down by 10 / sqrt(3) d / T^2."""
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q0 = world.positions(group)
    q1 = np.array(q0)
    q1[0] += 0.5
    request = request_for(world, "arm", quintic(group, q0, q1, 2.0))
    peak = 10 / np.sqrt(3) * 0.5 / 4
    name = group.joints[0].name
    for bounds, passes in (
        ((-1.001 * peak, 1.001 * peak), True),
        ((-0.999 * peak, 10.0), False),
        ((-10.0, 0.999 * peak), False),
    ):
        certificate = certificate_of(world, replace(request, acceleration_bounds={name: bounds}))
        failed = {check.name: check for check in certificate.failed}
        assert ("acceleration" not in failed) is passes
        if not passes:
            assert failed["acceleration"].where == name
