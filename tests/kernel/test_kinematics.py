"""The kernel's poses and Jacobians are Drake's, for every kind of joint and for mimics."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native
from planning.world.drake_model import Coupling, DrakeModel
from planning.world.kernel.kernel_tree import kernel_chain
from tests.certify.chains import FLOATING, P, R, Robot, random_robot
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")


def with_frames(robot: Robot) -> Robot:
    """Name every link's frame, as a loaded world does."""
    model = robot.model
    frames = {name: model.plant.get_body(i).body_frame() for name, i in model.bodies.items()}
    return replace(robot, model=replace(model, frames=frames))


def with_mimics(robot: Robot, rng: np.random.Generator) -> Robot:
    """Let scalar joints follow one another at random, with offsets; followers leave the group."""
    model = robot.model
    scalar = [j for j in robot.group.joints if j.type in (R, P)]
    order = [scalar[int(i)] for i in rng.permutation(len(scalar))]
    couplings, following = [], set()
    for follower, leader in zip(order[1:], order, strict=False):
        if rng.random() < 0.5:
            a, b = (model.plant.get_joint(model.joint_indices[j.name]) for j in (follower, leader))
            couplings.append(
                Coupling(
                    a.position_start(),
                    b.position_start(),
                    a.velocity_start(),
                    b.velocity_start(),
                    *rng.normal(size=2),
                )
            )
            following.add(follower.name)
    joints = tuple(j for j in robot.group.joints if j.name not in following)
    group = replace(robot.group, joints=joints)
    return replace(robot, model=replace(model, couplings=tuple(couplings)), group=group)


def made_up(seed: int, mass: float = np.nan) -> tuple[Robot, str, np.ndarray]:
    """Return a random robot, a frame of it, and configurations."""
    rng = np.random.default_rng(seed)
    robot = with_frames(random_robot(rng, int(rng.integers(1, 9)), 0, mass))
    if rng.random() < 0.5:
        robot = with_mimics(robot, rng)
    manifold = Manifold(robot.group.joints)
    q = np.zeros(robot.group.num_positions)
    begin = 0
    for joint in robot.group.joints:
        q[begin] = 1.0 if joint.type is FLOATING else 0.0
        begin += joint.num_positions
    qs = manifold.plus(np.repeat(q[None], 8, axis=0), rng.normal(size=(8, manifold.num_velocities)))
    frame = f"robot::link{int(rng.integers(len(robot.model.bodies)))}"
    return robot, frame, qs


def drake_pose(model: DrakeModel, context: Any, frame: str, full: np.ndarray) -> np.ndarray:
    model.plant.SetPositions(context, full)
    return model.frames[frame].CalcPoseInWorld(context).GetAsMatrix4()


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=num_cases(6))
def test_poses_are_drakes(seed: int) -> None:
    robot, frame, qs = made_up(seed)
    chain: Any = kernel_chain(robot.model, robot.group, robot.state, frame)
    context = robot.model.plant.CreateDefaultContext()
    for q, pose in zip(qs, chain.poses(qs), strict=True):
        full = robot.model.embed(robot.group, q, robot.state)
        expected = drake_pose(robot.model, context, frame, full)
        np.testing.assert_allclose(pose[:9].reshape(3, 3), expected[:3, :3], atol=1e-12)
        np.testing.assert_allclose(pose[9:], expected[:3, 3], atol=1e-11)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=num_cases(6))
def test_jacobians_are_the_slopes_of_drakes_poses(seed: int) -> None:
    """A column is the spatial velocity when one of Drake's v is 1: angular first, in W."""
    robot, frame, qs = made_up(seed)
    model, plant = robot.model, robot.model.plant
    chain: Any = kernel_chain(model, robot.group, robot.state, frame)
    context = plant.CreateDefaultContext()
    step = 1e-5
    for q, jacobian in zip(qs, chain.jacobians(qs), strict=True):
        full = model.embed(robot.group, q, robot.state)
        assert jacobian.shape == (6, len(model.velocity_indices(robot.group)))
        for column, index in zip(jacobian.T, model.velocity_indices(robot.group), strict=True):
            plant.SetPositions(context, full)
            qdot = np.array(plant.MapVelocityToQDot(context, np.eye(plant.num_velocities())[index]))
            ends = [
                drake_pose(model, context, frame, model.apply_couplings(full + sign * step * qdot))
                for sign in (-1, 1)
            ]
            slope = (ends[1] - ends[0]) / (2 * step)
            at = drake_pose(model, context, frame, full)
            spin = slope[:3, :3] @ at[:3, :3].T
            angular = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
            expected = np.concatenate([angular, slope[:3, 3]])
            np.testing.assert_allclose(column, expected, atol=1e-6)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=num_cases(20))
def test_gradients_of_velocities_are_their_slopes(seed: int) -> None:
    robot, frame, qs = made_up(seed)
    assume(all(joint.type is not FLOATING for joint in robot.group.joints))
    chain: Any = kernel_chain(robot.model, robot.group, robot.state, frame)
    vs = np.random.default_rng(seed).normal(size=qs.shape)
    step = 1e-6
    wanted = np.einsum("nij,nj->ni", chain.jacobians(qs)[:, 3:], vs)
    assert np.allclose(chain.velocities(qs, vs), wanted, rtol=0, atol=1e-12)
    found = chain.velocity_gradients(qs, vs)
    for j, direction in enumerate(np.eye(qs.shape[1])):
        after, before = (
            np.einsum("nij,nj->ni", chain.jacobians(qs + sign * step * direction)[:, 3:], vs)
            for sign in (1, -1)
        )
        scale = 1 + np.abs(found).max()
        np.testing.assert_allclose(
            found[:, :, j], (after - before) / (2 * step), rtol=0, atol=1e-8 * scale
        )


def test_what_the_group_does_not_move_stays() -> None:
    robot, frame, _ = made_up(7)
    few = replace(robot.group, joints=robot.group.joints[:1])
    state = robot.state + 0.1
    chain: Any = kernel_chain(robot.model, few, state, frame)
    q = state[robot.model.position_indices(few)]
    context = robot.model.plant.CreateDefaultContext()
    expected = drake_pose(robot.model, context, frame, robot.model.apply_couplings(np.array(state)))
    np.testing.assert_allclose(chain.poses(q[None])[0, 9:], expected[:3, 3], atol=1e-12)
