"""Clearance: proven motions are free, on any robot, and contacts are refused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Convex, Cylinder, Ellipsoid, HalfSpace, Shape, Sphere
from pydrake.math import RigidTransform, RollPitchYaw

from planning.certify.certifier import certify
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from planning.domain.request.deadline import Deadline
from planning.errors import Canceled, DeadlineExceeded
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_scene import kernel_scene_of
from tests.certify.chains import (
    FLOATING,
    PLANAR,
    Builder,
    P,
    Robot,
    fine_loop,
    random_robot,
    random_trajectory,
)
from tests.certify.conftest import quintic
from tests.clocks import FakeClock, no_hurry
from tests.profiles import num_cases

pytestmark = pytest.mark.usefixtures("implementation")

NO_MARGIN = PairMargins(0.0)


def certificate_of(
    robot: Robot, trajectory: TimedTrajectory, margins: PairMargins = NO_MARGIN
) -> Certificate:
    request = robot.request(trajectory, margins)
    return certify(robot.model, request, no_hurry(30.0))[0]


def clearance_of(certificate: Certificate) -> Any:
    return next(check for check in certificate.checks if check.name == "clearance")


def slider(shape: Shape, obstacle: Shape, at: np.ndarray) -> Robot:
    """Return a shape on a prismatic joint along z, and an obstacle."""
    builder = Builder()
    builder.link(P, shape)
    builder.obstacle("thing", obstacle, RigidTransform(at))
    return builder.build()


def test_the_chosen_proof_is_the_one_that_runs(implementation: str) -> None:
    robot = slider(Sphere(0.05), Sphere(0.1), np.array([0.2, 0.0, 0.3]))
    assert (kernel_scene_of(robot.model) is not None) is (implementation == "kernel")


@given(seed=st.integers(0, 100_000), margin=st.sampled_from([0.0, 0.0, 0.01]))
@settings(max_examples=num_cases(6))
def test_verdicts_on_random_robots_agree_with_dense_samples(seed: int, margin: float) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=3, num_obstacles=4)
    trajectory = random_trajectory(rng, robot.group, int(rng.integers(1, 4)), 0.25)
    certificate = certificate_of(robot, trajectory, PairMargins(margin))
    smallest = fine_loop(robot, trajectory)
    check = clearance_of(certificate)
    if check.passed:
        assert smallest > 0
        assert certificate.observed_clearance - check.resolution <= smallest + 1e-6
        if smallest < 0.2:
            assert certificate.observed_clearance >= smallest - 0.003
            assert certificate.observed_clearance <= smallest + max(2e-3, 0.011 * smallest)
    else:
        assert smallest <= margin + 0.003


@given(at=st.floats(-0.4, 0.4), beside=st.floats(0.02, 0.4), length=st.floats(0.1, 1.0))
def test_a_sphere_that_passes_a_sphere(at: float, beside: float, length: float) -> None:
    robot = slider(Sphere(0.05), Sphere(0.1), np.array([beside, 0.0, at]))
    q0, q1 = np.array([-length / 2]), np.array([length / 2])
    certificate = certificate_of(robot, quintic(robot.group, q0, q1, 1.0))
    past = max(abs(at) - length / 2, 0.0)
    smallest = float(np.hypot(beside, past)) - 0.15
    assert certificate.proven == (smallest > 0)
    if certificate.proven:
        resolution = clearance_of(certificate).resolution
        assert smallest - 1e-9 <= certificate.observed_clearance <= smallest + resolution + 1e-9
        assert resolution <= 1e-3 + 0.01 * certificate.observed_clearance + 1e-9
        nearest = quintic(robot.group, q0, q1, 1.0).positions(np.array([certificate.time]))[0, 0]
        measured = float(np.hypot(beside, at - nearest)) - 0.15
        assert measured == pytest.approx(certificate.observed_clearance, abs=1e-9)


@pytest.mark.parametrize("gap", [1e-4, 1e-5])
@pytest.mark.parametrize("shape", [Box(0.1, 0.1, 0.1), Sphere(0.05), Cylinder(0.05, 0.1)])
def test_a_head_on_approach_to_a_graze_is_proven(shape: Shape, gap: float) -> None:
    robot = slider(shape, Box(1.0, 1.0, 0.1), np.array([0.0, 0.0, 0.1 + 0.4]))
    q0, touch = np.array([0.0]), np.array([0.4])
    certificate = certificate_of(robot, quintic(robot.group, q0, touch - gap, 1.0))
    assert certificate.proven
    assert certificate.observed_clearance == pytest.approx(gap, abs=1e-6)
    for beyond in (0.0, gap):
        refused = certificate_of(robot, quintic(robot.group, q0, touch + beyond, 1.0))
        assert not refused.proven
        assert clearance_of(refused).where == "robot::link0-thing"


def test_a_contact_that_lasts_is_refused_at_once() -> None:
    robot = slider(Box(0.1, 0.1, 0.1), Box(0.1, 1.0, 4.0), np.array([0.1, 0.0, 0.0]))
    request = robot.request(quintic(robot.group, np.zeros(1), np.ones(1), 1.0), NO_MARGIN)
    certificate, report = certify(robot.model, request, no_hurry(30.0))
    assert not certificate.proven
    assert report.intervals < 50


def test_a_fast_pass_through_a_thin_plate_is_caught_anywhere() -> None:
    for at in np.linspace(-0.9, 0.9, 13):
        robot = slider(Box(0.02, 0.02, 0.02), Box(1.0, 1.0, 0.001), np.array([0.0, 0.0, at]))
        certificate = certificate_of(robot, quintic(robot.group, -np.ones(1), np.ones(1), 0.02))
        check = clearance_of(certificate)
        assert not check.passed
        assert check.value <= check.bound
        assert 0 < check.time < 0.02


GROUND_SHAPES = {
    "box": (Box(0.2, 0.4, 0.6), 0.3),
    "sphere": (Sphere(0.1), 0.1),
    "cylinder": (Cylinder(0.1, 0.5), 0.25),
    "ellipsoid": (Ellipsoid(0.1, 0.2, 0.3), 0.3),
    "convex": (Convex(np.asfortranarray(np.diag([0.1, 0.2, 0.3]) - 0.1), "c"), 0.1),
}


@pytest.mark.parametrize("name", GROUND_SHAPES)
def test_half_spaces_are_measured_against_every_shape(name: str) -> None:
    shape, below = GROUND_SHAPES[name]
    robot = slider(shape, HalfSpace(), np.array([0.3, 0.2, -1.0]))
    down = quintic(robot.group, np.zeros(1), np.array([-0.5]), 1.0)
    certificate = certificate_of(robot, down)
    assert certificate.proven
    assert certificate.observed_clearance == pytest.approx(0.5 - below, abs=1e-9)
    deep = quintic(robot.group, np.zeros(1), np.array([-1.0]), 1.0)
    assert clearance_of(certificate_of(robot, deep)).value == pytest.approx(-below, abs=1e-9)


def test_pairs_have_their_own_margins() -> None:
    robot = slider(Sphere(0.05), Sphere(0.1), np.array([0.2, 0.0, 0.3]))
    passing = quintic(robot.group, np.zeros(1), np.array([0.6]), 1.0)
    pair = ("robot::link0", "thing")
    assert certificate_of(robot, passing, PairMargins(0.049)).proven
    refused = certificate_of(robot, passing, PairMargins(0.051))
    assert clearance_of(refused).bound == 0.051
    assert clearance_of(refused).value < 0.051
    assert certificate_of(robot, passing, PairMargins(0.051, {pair: 0.049})).proven
    assert not certificate_of(robot, passing, PairMargins(0.0, {pair: 0.051})).proven
    exact = quintic(robot.group, np.array([0.3]), np.array([0.9]), 1.0)
    assert certificate_of(robot, exact, PairMargins(0.05)).proven


def test_static_pairs_are_measured_once() -> None:
    def beside(distance: float) -> Robot:
        builder = Builder()
        builder.link(P, Sphere(0.05))
        # A second robot that stands still: its mimic joint follows no joint of the group.
        builder.link(P, Sphere(0.05), None, RigidTransform(np.array([2.0, 0.0, 0.0])))
        builder.obstacle(
            "thing", Sphere(0.05), RigidTransform(np.array([2.1 + distance, 0.0, 0.0]))
        )
        built = builder.build()
        group = replace(built.group, joints=built.group.joints[:1])
        return Robot(built.model, group, built.state)

    for distance, proven in ((0.02, True), (0.005, False), (-0.01, False)):
        robot = beside(distance)
        moving = quintic(robot.group, np.zeros(1), np.ones(1), 1.0)
        certificate = certificate_of(robot, moving, PairMargins(0.01))
        assert certificate.proven is proven
        if not proven:
            check = clearance_of(certificate)
            assert check.where == "robot::link1-thing"
            assert check.value == pytest.approx(distance, abs=1e-6)


def test_followers_count_as_moving() -> None:
    def jaw(multiplier: float) -> Robot:
        builder = Builder()
        along = np.array([1.0, 0.0, 0.0])
        builder.link(P, Box(0.02, 0.02, 0.02), axis=along)
        builder.link(P, Box(0.02, 0.02, 0.02), axis=along)
        builder.followers.append((1, 0, multiplier))
        builder.obstacle("stop", Box(0.02, 0.02, 0.02), RigidTransform(np.array([-0.1, 0.0, 0.0])))
        return builder.build()

    # The leader moves away from the stop; only the follower can hit it.
    for multiplier, proven in ((-0.5, True), (-0.79, True), (-0.81, False), (-2.0, False)):
        robot = jaw(multiplier)
        opening = quintic(robot.group, np.array([0.03]), np.array([0.1]), 1.0)
        assert certificate_of(robot, opening).proven is proven


@pytest.mark.parametrize("kind", [PLANAR, FLOATING])
def test_a_bar_that_turns_beside_a_wall(kind: Any) -> None:
    reach = float(np.hypot(0.3, 0.05))

    def beside(gap: float) -> Robot:
        builder = Builder()
        builder.link(kind, Box(0.6, 0.1, 0.1))
        # Its corners sweep a circle in the plane; the wall stands where the circle ends.
        at = RigidTransform(np.array([0.0, reach + gap + 0.05, 0.0]))
        builder.obstacle("wall", Box(2.0, 0.1, 2.0), at)
        return builder.build()

    for gap, proven in ((1e-3, True), (-1e-3, False)):
        robot = beside(gap)
        q0 = np.zeros(3) if kind is PLANAR else np.eye(7)[0]
        turned = RollPitchYaw(0.0, 0.0, 1.2).ToQuaternion().wxyz()
        q1 = np.array([0.0, 0.0, 1.2]) if kind is PLANAR else np.concatenate([turned, np.zeros(3)])
        # A corner is nearest to the wall at pi/2 - 0.165 = 1.406 rad; the motion turns 1.68 rad.
        turning = quintic(robot.group, q0, q1, 2.0)
        certificate = certificate_of(
            robot, replace(turning, coefficients=turning.coefficients * 1.4)
        )
        assert certificate.proven is proven
        if proven:
            assert certificate.observed_clearance == pytest.approx(gap, abs=1e-3)


def test_without_time_there_is_no_verdict() -> None:
    robot = slider(Sphere(0.05), Sphere(0.1), np.array([0.2, 0.0, 0.3]))
    request = robot.request(quintic(robot.group, np.zeros(1), np.ones(1), 1.0), NO_MARGIN)
    with pytest.raises(DeadlineExceeded):
        certify(robot.model, request, no_hurry(0.0))
    with pytest.raises(Canceled):
        certify(robot.model, request, no_hurry(9.0, lambda: True))


def test_a_deadline_ends_a_long_proof() -> None:
    # A wheel that spins beside a wall: its distance is constant, but the motion bounds grow.
    builder = Builder()
    builder.link(FLOATING, Cylinder(0.1, 0.1))
    builder.obstacle("wall", Box(0.1, 1.0, 1.0), RigidTransform(np.array([0.15001, 0.0, 0.0])))
    robot = builder.build()
    turned = np.concatenate([RollPitchYaw(0.0, 0.0, 2.0).ToQuaternion().wxyz(), np.zeros(3)])
    request = robot.request(quintic(robot.group, np.eye(7)[0], turned, 1.0), NO_MARGIN)
    clock = FakeClock(step=0.0625)
    with pytest.raises(DeadlineExceeded):
        certify(robot.model, request, Deadline.after(0.5, clock))
    # It stopped at the first check of the clock after the deadline.
    assert clock.now == 0.5625


def test_without_obstacles_clearance_is_infinite() -> None:
    builder = Builder()
    builder.link(P, Sphere(0.05))
    robot = builder.build()
    certificate = certificate_of(robot, quintic(robot.group, np.zeros(1), np.ones(1), 1.0))
    assert certificate.proven
    assert certificate.observed_clearance == np.inf
    assert certificate.pair == ("", "")


@pytest.mark.parametrize(("meeting", "proven"), [(0.19, True), (0.21, False)])
def test_two_bodies_that_move_towards_each_other(meeting: float, proven: bool) -> None:
    builder = Builder()
    for at in (-0.25, 0.25):
        builder.link(P, Sphere(0.05), None, RigidTransform(np.array([0.0, 0.0, at])))
    robot = builder.build()
    together = quintic(robot.group, np.zeros(2), np.array([meeting, -meeting]), 1.0)
    certificate = certificate_of(robot, together)
    assert certificate.proven is proven
    # There and back: both ends are far apart, and so is every instant but the middle one.
    back = np.concatenate([together.coefficients, together.coefficients])
    back[1] *= -1
    bases = np.stack([np.zeros(2), np.array([meeting, -meeting])])
    there_and_back = TimedTrajectory(together.joints, np.array([0.0, 1.0, 2.0]), bases, back)
    assert certificate_of(robot, there_and_back).proven is proven
