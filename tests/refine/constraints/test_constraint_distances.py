"""Rules as distances: their gradients are those of what they leave."""

import numpy as np
import pytest

from planning.domain.curves.path import JointPath
from planning.domain.geometry.pose import Pose
from planning.domain.request.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    OrientationCone,
    PathConstraint,
    PlacedBox,
)
from planning.domain.robot.joints import JointGroup
from planning.refine.constraints.band_distances import BandDistanceQuery
from planning.refine.constraints.constraint_distances import ConstraintDistanceQuery
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import make_distance_query
from planning.refine.curves.chart import FlatChart
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.loading.load_world import load_world
from tests.conftest import bundled_world

FRAME = "arm::tool0"
BOX = PlacedBox(np.array([0.5, 0.4, 0.6]), Pose.from_parts([0.4, 0.1, 0.4], rpy=[0.1, 0.2, 0.3]))
DIRECTION = np.array([0.3, -0.2, 1.0])
FAR = 100.0


def along(group: JointGroup, q: np.ndarray) -> FlatChart:
    return FlatChart(JointPath(group, np.stack([q, q + 1.0])))


@pytest.mark.parametrize(
    "constraint",
    [
        KeepIn(FRAME, BOX),
        KeepOut(FRAME, BOX),
        OrientationCone(FRAME, np.array([0.0, 0.0, 1.0]), DIRECTION, 0.4),
    ],
)
def test_room_and_gradient_are_those_of_the_rule(constraint: PathConstraint) -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    rng = np.random.default_rng(3)
    start = world.positions(group)
    rules = PathConstraints.compiled(world, group, (constraint,), start)
    buffers = DistanceBuffers.from_ends(world, world.margins(), world.embed(group, start[None]))
    bare = make_distance_query(world, group, buffers)
    near = ConstraintDistanceQuery(bare, rules, along(group, start))
    qs = start + rng.normal(0.0, 0.5, (40, 6))
    seen, others = near.within(qs, FAR), bare.within(qs, FAR)
    num = len(others.sample_indices)
    np.testing.assert_array_equal(seen.sample_indices[:num], others.sample_indices)
    np.testing.assert_array_equal(seen.sample_indices[num:], np.arange(40))
    spare, gradient = seen.signed_margins[num:], seen.gradients[num:]
    np.testing.assert_array_equal(spare >= -1e-6, rules.are_satisfied(qs))
    # Along any short way the room changes as the gradient says, but where a face becomes another.
    way = rng.normal(size=(40, 6))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    step = 1e-4
    there = near.within(qs + step * way, FAR).signed_margins[-40:]
    errors = np.abs((there - spare) / step - (gradient * way).sum(axis=1))
    assert np.median(errors) < 1e-3
    assert (errors < 0.02).sum() >= 38


def test_what_leaves_much_room_is_not_told() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    start = world.positions(group)
    wide = PlacedBox(np.array([50.0, 50.0, 50.0]), Pose.identity())
    rules = PathConstraints.compiled(world, group, (KeepIn(FRAME, wide),), start)
    buffers = DistanceBuffers.from_ends(world, world.margins(), world.embed(group, start[None]))
    bare = make_distance_query(world, group, buffers)
    seen = ConstraintDistanceQuery(bare, rules, along(group, start)).within(start[None], 0.1)
    assert len(seen.sample_indices) == len(bare.within(start[None], 0.1).sample_indices)


WALLS = [([0.4, 1.0, 0.2], [-0.5, 0.0, 0.0]), ([0.4, 0.6, 0.2], [0.45, 0.0, 0.0])]


def distances(qs: np.ndarray) -> np.ndarray:
    """Return how far a puck is from each of the walls, shape (m, 2)."""
    sides = np.array([size[:2] for size, _ in WALLS]) / 2
    middles = np.array([centre[:2] for _, centre in WALLS])
    beyond = np.maximum(np.abs(qs[:, None] - middles) - sides, 0.0)
    return np.linalg.norm(beyond, axis=2) - 0.02


@pytest.mark.parametrize("kernel", [True, False])
@pytest.mark.parametrize("far", [0.2, np.inf])
def test_a_band_has_room_to_both_bounds(make_puck, kernel: bool, far: float) -> None:
    world = make_puck(WALLS)
    world = load_world(world.scene, world.library, kernel=kernel)
    group = world.group("puck")
    band = DistanceBand(None, None, 0.05, far)
    (rule,) = PathConstraints.compiled(world, group, (band,), np.zeros(2)).constraints
    rule = rule.tightened(0.004)
    measure = BandDistanceQuery(rule, along(group, np.zeros(2)))
    rng = np.random.default_rng(1)
    qs = rng.uniform([-0.25, -0.9], [0.2, 0.9], (60, 2))
    qs = qs[distances(qs).min(axis=1) > 0.001]
    seen = measure.within(qs, 0.3)
    told = np.full(len(qs), np.inf)
    np.minimum.at(told, seen.sample_indices, seen.signed_margins)
    nearest = distances(qs).min(axis=1)
    room = np.minimum(nearest - 0.054, far - 0.004 - nearest)
    is_told = room < 0.3
    np.testing.assert_allclose(told[is_told], np.maximum(room, -0.3)[is_told], atol=1e-6)
    np.testing.assert_array_equal(told[room > 1e-6] > 0, True)
    np.testing.assert_array_equal(
        (told > 0)[np.abs(room) > 1e-5], rule.are_satisfied(qs)[np.abs(room) > 1e-5]
    )
    # Row by row, what is told beforehand of a short way is what comes.
    way = rng.normal(size=2) * 1e-5
    there = measure.within(qs + way, 0.3)
    np.testing.assert_array_equal(there.sample_indices, seen.sample_indices)
    errors = np.abs(there.signed_margins - seen.signed_margins - seen.gradients @ way)
    assert np.median(errors) < 1e-9
    assert (errors < 1e-7).mean() > 0.95
