"""Nearest points: on both shapes, and as far apart as the certificate says."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, HalfSpace, Sphere

from planning.certify.certifier import certify
from planning.certify.clearance.clearance_result import WitnessPoint
from planning.certify.clearance.collision_shapes import collision_shapes
from planning.certify.clearance.nearest_points import nearest_points
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from planning.kernel.gjk import closest_points
from planning.world.collision.margins import PairMargins
from planning.world.world import World
from tests.certify.chains import Robot, random_robot, random_trajectory
from tests.certify.clearance.test_clearance_check import slider
from tests.certify.clearance.test_separation import parallel_boxes
from tests.certify.conftest import quintic, request_for
from tests.clocks import no_hurry
from tests.profiles import num_cases

pytestmark = pytest.mark.usefixtures("implementation")


def certificate_of(robot: Robot, trajectory: TimedTrajectory) -> Certificate:
    request = robot.request(trajectory, PairMargins(0.0))
    return certify(robot.model, request, no_hurry(30.0))[0]


def excess(robot: Robot, trajectory: TimedTrajectory, certificate: Certificate, i: int) -> float:
    """Return how far a point lies outside of its body, by half spaces around the body's shapes."""
    plant, shapes = robot.model.plant, collision_shapes(robot.model)
    context = plant.CreateDefaultContext()
    q = trajectory.positions(np.array([certificate.time]))[0]
    plant.SetPositions(context, robot.model.embed(robot.group, q, robot.state))
    body = plant.get_body(robot.model.bodies[certificate.pair[i]])
    pose = plant.EvalBodyPoseInWorld(context, body)
    directions = np.random.default_rng(0).normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    outside = []
    for row in np.flatnonzero(shapes.bodies == int(body.index())):
        rows = np.full(len(directions), row)
        R_WG = np.tile(pose.rotation().matrix() @ shapes.R_BG[row], (len(rows), 1, 1))
        p_wg = np.tile(pose.multiply(shapes.p_bg[row]), (len(rows), 1))
        tops = shapes.support(rows, R_WG, p_wg, directions)
        outside.append((directions @ certificate.points[i] - tops).max())
    return min(outside)


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(6))
def test_they_are_on_both_bodies_and_that_far_apart(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=3, num_obstacles=4)
    trajectory = random_trajectory(rng, robot.group, 2, 0.3)
    certificate = certificate_of(robot, trajectory)
    assert certificate.points.shape == (2, 3)
    apart = float(np.linalg.norm(certificate.points[0] - certificate.points[1]))
    # Either search may overestimate the depth, by little.
    tolerance = 2e-5 if certificate.observed_clearance > 0 else 5e-3
    assert apart == pytest.approx(abs(certificate.observed_clearance), abs=tolerance)
    assert all(excess(robot, trajectory, certificate, i) < 1e-4 for i in (0, 1))


def test_over_a_half_space_they_are_one_above_the_other() -> None:
    robot = slider(Sphere(0.1), HalfSpace(), np.array([0.3, 0.2, -1.0]))
    certificate = certificate_of(robot, quintic(robot.group, np.zeros(1), np.array([-0.5]), 1.0))
    heights = dict(zip(certificate.pair, certificate.points, strict=True))
    np.testing.assert_allclose(heights["robot::link0"], [0.0, 0.0, -0.6], atol=1e-9)
    np.testing.assert_allclose(heights["thing"], [0.0, 0.0, -1.0], atol=1e-9)


def test_a_distance_that_drake_overstates_is_not_shown() -> None:
    robot, pose, true = parallel_boxes()
    certificate = certificate_of(robot, quintic(robot.group, pose, pose + 1e-9, 1.0))
    apart = np.linalg.norm(certificate.points[0] - certificate.points[1])
    assert apart == pytest.approx(true, abs=1e-6)
    points = dict(zip(certificate.pair, certificate.points, strict=True))
    np.testing.assert_allclose(points["post"][:2], [0.03, -0.40], atol=1e-6)


def test_faces_that_face_each_other_have_points_in_both() -> None:
    robot = slider(Box(0.1, 0.1, 0.1), Box(1.0, 1.0, 0.1), np.array([0.0, 0.0, 0.6]))
    certificate = certificate_of(robot, quintic(robot.group, np.zeros(1), np.array([0.3]), 1.0))
    (x, y, _), (other_x, other_y, _) = certificate.points
    assert (x, y) == pytest.approx((other_x, other_y), abs=1e-9)
    assert max(abs(x), abs(y)) <= 0.05 + 1e-9
    assert sorted(certificate.points[:, 2]) == pytest.approx([0.35, 0.55], abs=1e-9)


@given(seed=st.integers(0, 100_000))
def test_our_own_search_finds_those_of_balls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    centers, radii = rng.normal(size=(2, 3)), rng.uniform(0.01, 0.3, 2)
    between = centers[1] - centers[0]
    unit = between / np.linalg.norm(between)
    if np.linalg.norm(between) < radii.sum() + 0.01:
        return
    balls = [
        lambda n, c=c, r=r: c + r * n / np.linalg.norm(n)
        for c, r in zip(centers, radii, strict=True)
    ]
    found = closest_points(*balls, -between)
    expected = [centers[0] + radii[0] * unit, centers[1] - radii[1] * unit]
    np.testing.assert_allclose(found, expected, atol=1e-4)


def test_without_a_pair_there_are_none() -> None:
    rng = np.random.default_rng(1)
    robot = random_robot(rng, num_links=1, num_obstacles=0)
    certificate = certificate_of(robot, random_trajectory(rng, robot.group, 1, 0.3))
    assert certificate.points.shape == (0, 3)


def test_of_two_bodies_all_shapes_are_measured(urdf_world: Callable[..., World]) -> None:
    """The proof may have measured a pair of their shapes that is not the nearest."""
    near, far = (
        f'<collision><origin xyz="{x} 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>'
        for x in (0.3, -0.3)
    )
    joint = '<joint name="j" type="continuous"><parent link="b"/><child link="a"/></joint>'
    robot = f'<robot name="m"><link name="b"/><link name="a">{far}{near}</link>{joint}</robot>'
    thing = {"name": "o", "shape": {"sphere": 0.1}, "pose": {"position": [0.8, 0, 0]}}
    world = urdf_world(robot, objects=[thing])
    model, group = world.drake, world.group("r")
    request = request_for(world, "r", quintic(group, np.zeros(1), np.full(1, 1e-6), 1.0))
    plant, static = model.plant, model.static_objects
    ball, *_ = plant.GetCollisionGeometriesForBody(plant.get_body(model.bodies["r::a"]))
    (thing,) = static.ids or plant.GetCollisionGeometriesForBody(plant.get_body(model.bodies["o"]))
    witness = WitnessPoint((ball, thing), ("r::a", "o"), 0.9, 0.0)
    points, distance = nearest_points(model, request, witness)
    assert distance == pytest.approx(0.3, abs=1e-6)
    np.testing.assert_allclose(points[:, 0], [0.4, 0.7], atol=1e-6)
    back = replace(witness, shapes=witness.shapes[::-1], bodies=witness.bodies[::-1])
    np.testing.assert_allclose(nearest_points(model, request, back)[0], points[::-1], atol=1e-6)
