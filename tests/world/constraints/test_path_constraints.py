"""Rules: their slopes, their distances and their edges agree with what defines them."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    OrientationCone,
    PathConstraint,
    PlacedBox,
)
from planning.world.constraints.body_pairs import banded_pairs, moved_bodies
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World
from tests.conftest import bundled_world
from tests.profiles import num_cases, seeds

TCP = "arm::tcp"
BAND = DistanceBand(None, None, 0.01, 0.05)


def rules_of(world: World, group: str, *constraints: PathConstraint) -> PathConstraints:
    joints = world.group(group)
    return PathConstraints.compiled(world, joints, constraints, world.positions(joints))


@cache
def without_kernel(name: str) -> World:
    """Return a bundled scene in which Drake alone places frames."""
    return planning.load_world(bundled_world(name).scene, kernel=False)


@pytest.mark.campaign
@pytest.mark.parametrize("load", [bundled_world, without_kernel])
@pytest.mark.parametrize("seed", seeds(3))
def test_the_jacobian_is_the_slope_of_the_residual(load: Callable[[str], World], seed: int) -> None:
    world = load("ur5e_pickup")
    rng = np.random.default_rng(seed)
    q = world.positions(world.group("arm")) + rng.normal(0, 0.3, 6)
    pose = Pose.from_parts([0.2, 0.1, 0.3], rpy=[0.3, 0.2, 0.1])
    box = PlacedBox(np.array([0.01, np.inf, 0.01]), pose)
    cone = OrientationCone(TCP, rng.normal(size=3), rng.normal(size=3), 0.05)
    residual = rules_of(world, "arm", KeepIn(TCP, box), cone).residual
    assert residual is not None
    assert residual.size == len(residual.residual(q)) == 4
    slopes = residual.jacobian(q)
    for k, step in enumerate(np.eye(6) * 1e-6):
        difference = (residual.residual(q + step) - residual.residual(q - step)) / 2e-6
        np.testing.assert_allclose(slopes[:, k], difference, atol=1e-6)


def test_the_kernel_and_drake_agree_on_a_band() -> None:
    """A ball, since Drake overstates distances of boxes."""
    text = """
robots: [{name: body, model: planar_l, positions: [-0.3, 0.0, 0.0]}]
objects: [{name: ball, shape: {sphere: 0.1}, pose: {position: [0.0, 0.2, 0.03]}}]
"""
    rng = np.random.default_rng(0)
    low, high = [-0.2, 0.0, -3.0], [0.2, 0.4, 3.0]
    qs = rng.uniform(low, high, size=(300, 3))
    with_kernel = planning.load_world(planning.parse_scene(text))
    without = planning.load_world(planning.parse_scene(text), kernel=False)
    answers = []
    for world in (with_kernel, without):
        joints = world.group("body")
        free = world.collision_oracle(joints, world.margins()).are_free(qs)
        rules = PathConstraints.compiled(world, joints, (BAND,), qs[0])
        answers.append(free & rules.are_satisfied(qs))
    np.testing.assert_array_equal(*answers)
    assert 10 < answers[0].sum() < 290


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 10_000))
def test_an_edge_is_kept_if_its_samples_are(seed: int) -> None:
    world = bundled_world("maze_2d_band")
    rules = rules_of(world, "body", BAND)
    joints = world.group("body")
    judge = world.collision_oracle(joints, world.margins())
    rng = np.random.default_rng(seed)
    origin = world.positions(joints) + rng.normal(0, 0.01, 3)
    step = rng.normal(0, 0.03, 3)
    resolution = rules.constraints[0].step
    count = max(1, int(np.ceil(np.linalg.norm(step) / resolution - 1e-9)))
    samples = origin + np.arange(1, count + 1)[:, None] / count * step
    expected = bool((judge.are_free(samples) & rules.are_satisfied(samples)).all())
    oracle = rules.oracle(judge)
    assert oracle.is_motion_free(origin, step, 0.5) == expected
    assert bool(oracle.are_motions_free(origin[None], step[None], 0.5)[0]) == expected


def test_room_is_left_only_where_the_ends_have_it() -> None:
    world = bundled_world("ur5e_pickup")
    joints = world.group("arm")
    start = world.positions(joints)
    pose = world.frame_pose(TCP, world.embed(joints, start))
    roomy = KeepIn(TCP, PlacedBox(np.full(3, 0.2), Pose.from_parts(pose.position)))
    tight = KeepIn(
        TCP, PlacedBox(np.full(3, 0.2), Pose.from_parts(pose.position + np.array([0.0999, 0, 0])))
    )
    rooms = [
        rules_of(world, "arm", constraint).tightened(start, start[None]).constraints[0].margin
        for constraint in (roomy, tight)
    ]
    assert rooms == [4e-3, 0.0]


def test_keep_out_measures_from_the_faces() -> None:
    world = bundled_world("ur5e_pickup")
    joints = world.group("arm")
    q = world.positions(joints)
    pose = world.frame_pose(TCP, world.embed(joints, q))
    box = PlacedBox(np.full(3, 0.1), Pose.from_parts(pose.position + np.array([0.0, 0.02, 0.0])))
    (rule,) = rules_of(world, "arm", KeepOut(TCP, box)).constraints
    assert rule.value(q).value == pytest.approx(0.03)
    assert not rule.are_satisfied(q[None])[0]


def test_a_band_speaks_of_what_moves_and_may_collide() -> None:
    world = bundled_world("ur5e_pickup")
    joints = world.group("arm")
    moving = moved_bodies(world.drake, joints)
    assert "arm::base_link" not in moving
    assert "arm::wrist_3_link" in moving
    pairs = banded_pairs(world, joints, DistanceBand(None, ("table",), 0.0, 1.0), "x")
    assert all("table" in pair for pair in pairs)
    assert ("arm::wrist_3_link", "table") in pairs
