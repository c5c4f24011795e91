"""Clearance of half spaces, at rest and on links that turn, against closed formulas."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Convex, HalfSpace, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from planning.certify.certifier import certify
from planning.certify.clearance.clearance_reserve import robustness
from planning.certify.clearance.collision_shapes import collision_shapes
from planning.certify.clearance.motion_bounds import MotionBounds
from planning.certify.clearance.native_clearance import prover
from planning.certify.clearance.pair_distances import PairDistances
from planning.certify.intervals.joint_deviation import Segments
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_scene import kernel_scene
from tests.certify.chains import PLANAR, Builder, P, R, Robot, random_trajectory
from tests.certify.clearance.test_clearance_check import NO_MARGIN, certificate_of, clearance_of
from tests.certify.conftest import quintic
from tests.certify.half_spaces import Heights, Place
from tests.clocks import no_hurry
from tests.profiles import num_cases, pairs

BOTH_PROOFS = pytest.mark.usefixtures("implementation")


def random_motion(place: Place) -> tuple[Robot, TimedTrajectory]:
    robot = place.robot()
    return robot, random_trajectory(np.random.default_rng(place.seed + 1), robot.group, 1, 0.1)


@BOTH_PROOFS
@given(seed=st.integers(0, 2**31), is_carried=st.booleans())
@settings(max_examples=num_cases(3))
def test_motions_above_are_proven_and_motions_into_it_are_refused(
    seed: int, is_carried: bool
) -> None:
    robot, motion = random_motion(Place(seed, is_carried))
    smallest = Heights(robot).along(motion)
    for gap in (3e-3, -1e-6):
        robot, motion = random_motion(Place(seed, is_carried, gap - smallest))
        least = Heights(robot).along(motion)
        assert least == pytest.approx(gap, abs=1e-9)
        certificate = certificate_of(robot, motion)
        assert certificate.proven is (gap > 0)
        if certificate.proven:
            check = clearance_of(certificate)
            assert check.value - check.resolution <= least + 1e-9
            assert check.value >= least - 1e-4


@given(seed=st.integers(0, 2**31), is_carried=st.booleans())
@settings(max_examples=num_cases(6))
def test_no_pair_approaches_by_more_than_its_bound(seed: int, is_carried: bool) -> None:
    """The bound on a pair's approach, on random segments of random motions."""
    robot, motion = random_motion(Place(seed, is_carried))
    heights, rng = Heights(robot), np.random.default_rng(seed + 2)
    distances = PairDistances(robot.model, robot.request(motion, NO_MARGIN))
    every = np.arange(len(distances.pairs.ids))
    rows = [distances.pairs.index[pair] for pair in heights.pairs]
    segments = Segments(motion)
    segment = segments.whole
    for _ in range(int(rng.integers(5))):
        segment = segments.halves(segment)[int(rng.integers(2))]
    distances.set_positions(segment.center)
    allowed = distances.max_approaches(segment, every)[rows]
    assert np.isfinite(allowed).all()
    here = heights.at(segment.center)
    np.testing.assert_allclose(
        distances.measure(every, np.zeros(len(every))).lower_bounds[rows], here
    )
    for time in np.linspace(segment.begin, segment.end, 17)[:-1]:
        there = heights.at(motion.positions(np.array([time]))[0])
        assert (here - there <= allowed + 1e-9).all()


@given(seed=st.integers(0, 2**31), is_carried=st.booleans())
@settings(max_examples=num_cases(6))
def test_the_kernels_bounds_hold_on_every_segment(seed: int, is_carried: bool) -> None:
    robot, motion = random_motion(Place(seed, is_carried))
    scene = kernel_scene(robot.model)
    if scene is None:
        pytest.skip("the native kernel is not built")
    heights, rng = Heights(robot), np.random.default_rng(seed + 2)
    order = {pair: row for row, pair in enumerate(scene.pairs)}
    rows = [order.get(pair, order.get(pair[::-1])) for pair in heights.pairs]
    margins = scene.pair_margins(NO_MARGIN)
    proof = prover(scene, robot.model, robot.request(motion, NO_MARGIN), margins)
    for depth in range(5):
        begin, end, time, found = proof.bounds(rng.integers(2, size=depth).tolist())
        approach, lower, along = found[rows].T
        assert np.isfinite(approach).all()
        here = heights.at(motion.positions(np.array([time]))[0])
        np.testing.assert_allclose(lower, here - approach, atol=1e-9)
        for instant in np.linspace(begin, end, 17)[:-1]:
            there = heights.at(motion.positions(np.array([instant]))[0])
            assert (there >= lower - 1e-9).all()
            assert (there >= along - 1e-9).all()


FAR_SHAPES = {
    "sphere": (Sphere(0.1), 0.1),
    "box": (Box(0.2, 0.4, 0.6), 0.3),
    "convex": (Convex(np.asfortranarray(np.diag([0.1, 0.2, 0.3]) - 0.1), "c"), 0.1),
}


FAR_PLACES = list(product([0.0, 100.0, 1000.0], [0.0, 0.4]))


@pytest.mark.campaign
@pytest.mark.parametrize(("name", "place"), pairs(list(FAR_SHAPES), FAR_PLACES))
def test_a_micrometre_decides_far_from_the_origin(
    implementation: str, name: str, place: tuple[float, float]
) -> None:
    (shape, below), (away, roll) = FAR_SHAPES[name], place
    turned = RotationMatrix.MakeXRotation(roll)
    for gap in (1e-6, -1e-6):
        builder = Builder()
        # Where the shape's own axes are the half space's, `away` along its plane.
        at = turned @ np.array([away, -away, below + gap])
        builder.link(PLANAR, shape, x_pf=RigidTransform(turned, at))
        builder.obstacle("ground", HalfSpace(), RigidTransform(turned, np.zeros(3)))
        robot = builder.build()
        # What slides and turns along the plane is proven by the second order, which Drake's way
        # does not have: there it slides by a tenth of a millimetre.
        ends = np.array([[-1.0, 0.0, 0.0], [1.0, 0.5, 0.3]])
        if implementation == "drake":
            ends = np.array([[0.0, 0.0, 0.0], [0.0, 1e-4, 0.0]])
        certificate = certificate_of(robot, quintic(robot.group, *ends, 1.0))
        assert certificate.proven is (gap > 0)
        assert clearance_of(certificate).value == pytest.approx(gap, abs=1e-8)


def tilting() -> Robot:
    """Return a half space that turns about the x axis under a ball that stands still."""
    builder = Builder()
    builder.link(R, HalfSpace(), axis=np.array([1.0, 0.0, 0.0]))
    builder.obstacle("ball", Sphere(0.1), RigidTransform(np.array([0.0, 0.5, 0.4])))
    return builder.build()


def tilted(robot: Robot, angle: float) -> TimedTrajectory:
    return quintic(robot.group, np.zeros(1), np.array([angle]), 1.0)


# The ball's lowest point is at 0.4 cos a - 0.5 sin a - 0.1 over a plane that is tilted by a.
TOUCH = float(np.arccos(0.1 / np.hypot(0.4, 0.5)) - np.arctan2(0.5, 0.4))


@BOTH_PROOFS
@pytest.mark.parametrize(("before", "proven"), [(1e-4, True), (-1e-6, False), (-0.3, False)])
def test_a_half_space_that_turns_is_proven_up_to_touch(before: float, proven: bool) -> None:
    robot = tilting()
    certificate = certificate_of(robot, tilted(robot, TOUCH - before))
    assert certificate.proven is proven
    if proven:
        slope = 0.4 * np.sin(TOUCH) + 0.5 * np.cos(TOUCH)
        assert clearance_of(certificate).value == pytest.approx(slope * before, rel=1e-3)
    else:
        assert certificate.pair == ("robot::link0", "ball")
        assert certificate.points.shape == (2, 3)


@BOTH_PROOFS
def test_margins_hold_over_a_half_space_that_turns() -> None:
    robot = tilting()
    angle = TOUCH - 0.05
    height = 0.4 * np.cos(angle) - 0.5 * np.sin(angle) - 0.1
    assert certificate_of(robot, tilted(robot, angle), PairMargins(height - 1e-5)).proven
    assert not certificate_of(robot, tilted(robot, angle), PairMargins(height + 1e-5)).proven


@BOTH_PROOFS
def test_two_half_spaces_always_overlap() -> None:
    builder = Builder()
    builder.link(P, HalfSpace())
    builder.obstacle("ground", HalfSpace(), RigidTransform(np.array([0.0, 0.0, -5.0])))
    robot = builder.build()
    certificate = certificate_of(robot, quintic(robot.group, np.zeros(1), np.ones(1), 1.0))
    assert not certificate.proven
    assert clearance_of(certificate).value == -np.inf
    assert clearance_of(certificate).where == "robot::link0-ground"


@BOTH_PROOFS
def test_robustness_under_a_half_space_that_turns() -> None:
    robot = tilting()
    motion = tilted(robot, 0.1)
    request = robot.request(motion, NO_MARGIN)
    proven: Certificate = certify(robot.model, request, no_hurry(30.0))[0]
    assert proven.proven
    found = robustness(robot.model, request, no_hurry(30.0))
    # The height at 0.1 rad, and the angle left to touch, less what bounds of first order cost.
    height = 0.4 * np.cos(0.1) - 0.5 * np.sin(0.1) - 0.1
    assert found.obstacle_displacement <= height + 1e-9
    assert found.obstacle_displacement == pytest.approx(height, rel=0.02)
    arm = np.hypot(0.4, 0.5) + 0.1
    assert found.joint_error == pytest.approx(height / arm, rel=0.02)
    assert 0.1 + found.joint_error < TOUCH


def test_lever_arms_are_those_of_the_other_shape() -> None:
    robot = tilting()
    shapes = collision_shapes(robot.model)
    bounds = MotionBounds(robot.model, robot.group, shapes)
    distances = PairDistances(robot.model, robot.request(tilted(robot, 0.2), NO_MARGIN))
    whole = Segments(tilted(robot, 0.2)).whole
    distances.set_positions(whole.center)
    (approach,) = distances.max_approaches(whole, np.arange(1))
    arm = np.hypot(0.4, 0.5) + 0.1
    assert approach == pytest.approx(2 * np.sin(whole.max_rotation[0] / 2) * arm)
    assert bounds.is_carried_by.sum() == 1
