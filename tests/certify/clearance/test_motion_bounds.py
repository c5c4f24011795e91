"""No point moves farther than its bound, for any chain and motion."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint

from planning.certify.clearance.collision_shapes import collision_shapes
from planning.certify.clearance.motion_bounds import MotionBounds
from planning.certify.intervals.joint_deviation import Segment, Segments
from tests.certify.chains import Builder, P, R, Robot, random_robot, random_trajectory
from tests.profiles import num_cases


def poses(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    plant = robot.model.plant
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, robot.model.embed(robot.group, q, robot.state))
    every: list[Any] = [plant.world_body(), *map(plant.get_body, robot.model.body_names)]
    rotations, positions = np.zeros((len(every), 3, 3)), np.zeros((len(every), 3))
    for body in every:
        pose = plant.EvalBodyPoseInWorld(context, body)
        rotations[int(body.index())] = pose.rotation().matrix()
        positions[int(body.index())] = pose.translation()
    return rotations, positions


def descend(rng: np.random.Generator, segments: Segments) -> Segment:
    segment = segments.whole
    for _ in range(int(rng.integers(9))):
        segment = segments.halves(segment)[int(rng.integers(2))]
    return segment


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(6))
def test_points_stay_within_their_bounds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links=4, num_obstacles=0)
    trajectory = random_trajectory(rng, robot.group, 3, 0.5)
    shapes = collision_shapes(robot.model)
    bounds = MotionBounds(robot.model, robot.group, shapes)
    segment = descend(rng, Segments(trajectory))
    before = poses(robot, segment.center)
    reaches = bounds.max_displacements(*before, segment.max_rotation, segment.max_translation)
    for time in np.linspace(segment.begin, segment.end, 9)[[0, 1, 3, 5, 7, 8]]:
        # At a break the piece before it and the one after it agree.
        after = poses(robot, trajectory.positions(np.array([time]))[0])
        for a in range(len(shapes.bodies)):
            for b in range(len(shapes.bodies)):
                allowed = reaches[a, bounds.is_carried_by[a] & ~bounds.is_carried_by[b]].sum()
                allowed += reaches[b, bounds.is_carried_by[b] & ~bounds.is_carried_by[a]].sum()
                assert _approach(shapes, before, after, a, b) <= allowed + 1e-9


def _approach(shapes: Any, before: Any, after: Any, a: int, b: int) -> float:
    """Return by how much the centres of two shapes' spheres have come nearer."""
    distances = []
    for rotations, positions in (before, after):
        body_a, body_b = shapes.bodies[a], shapes.bodies[b]
        p_a = rotations[body_a] @ shapes.centers[a] + positions[body_a]
        p_b = rotations[body_b] @ shapes.centers[b] + positions[body_b]
        distances.append(float(np.linalg.norm(p_a - p_b)))
    return distances[0] - distances[1]


def test_a_lone_lever_is_bounded_by_its_chord() -> None:
    builder = Builder()
    builder.link(R, Sphere(0.1), x_bg=RigidTransform(np.array([1.0, 0.0, 5.0])))
    robot = builder.build()
    bounds = MotionBounds(robot.model, robot.group, collision_shapes(robot.model))
    turned = bounds.max_displacements(*poses(robot, np.zeros(1)), np.array([0.2]), np.zeros(1))
    assert turned[0, 0] == pytest.approx(2 * np.sin(0.1) * 1.1)
    far = bounds.max_displacements(*poses(robot, np.zeros(1)), np.array([50.0]), np.zeros(1))
    assert far[0, 0] == pytest.approx(2 * 1.1)


def test_followers_move_as_their_leader_times_their_factor() -> None:
    builder = Builder()
    builder.link(P, Box(0.1, 0.1, 0.1))
    builder.link(P, Box(0.1, 0.1, 0.1))
    builder.followers.append((1, 0, -2.0))
    robot = builder.build()
    bounds = MotionBounds(robot.model, robot.group, collision_shapes(robot.model))
    moved = bounds.max_displacements(*poses(robot, np.zeros(1)), np.zeros(1), np.array([0.1]))
    moved = np.where(bounds.is_carried_by, moved, 0.0)
    assert sorted(moved.sum(axis=1)) == pytest.approx([0.1, 0.2])


def test_followers_of_followers_move_too() -> None:
    builder = Builder()
    for _ in range(3):
        builder.link(P, Box(0.1, 0.1, 0.1))
    builder.followers += [(1, 0, -2.0), (2, 1, 3.0)]
    robot = builder.build()
    bounds = MotionBounds(robot.model, robot.group, collision_shapes(robot.model))
    moved = bounds.max_displacements(*poses(robot, np.zeros(1)), np.zeros(1), np.array([0.1]))
    moved = np.where(bounds.is_carried_by, moved, 0.0)
    assert sorted(moved.sum(axis=1)) == pytest.approx([0.1, 0.2, 0.6])


def test_a_joint_that_runs_from_child_to_parent_still_moves_its_body() -> None:
    builder = Builder()
    link = builder.body("robot::link0", Sphere(0.1), RigidTransform(np.array([1.0, 0.0, 0.0])))
    plant: MultibodyPlant = builder.plant
    axis = np.array([0.0, 0.0, 1.0])
    joint = RevoluteJoint("j0", link.body_frame(), plant.world_frame(), axis)
    builder.joints.append(plant.AddJoint(joint))
    builder.types.append(R)
    builder.links.append(link)
    robot = builder.build()
    bounds = MotionBounds(robot.model, robot.group, collision_shapes(robot.model))
    turned = bounds.max_displacements(*poses(robot, np.zeros(1)), np.array([0.2]), np.zeros(1))
    assert turned[0, 0] == pytest.approx(2 * np.sin(0.1) * 1.1)
