"""Path constraints as distances: signed margins and their gradients."""

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
def test_margin_and_gradient_are_those_of_the_constraint(constraint: PathConstraint) -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    rng = np.random.default_rng(3)
    start = world.positions(group)
    constraints = PathConstraints.compiled(world, group, (constraint,), start)
    buffers = DistanceBuffers.from_ends(world, world.margins(), world.embed(group, start[None]))
    bare = make_distance_query(world, group, buffers)
    both = ConstraintDistanceQuery(bare, constraints, along(group, start))
    qs = start + rng.normal(0.0, 0.5, (40, 6))
    rows, others = both.within(qs, FAR), bare.within(qs, FAR)
    num = len(others.sample_indices)
    np.testing.assert_array_equal(rows.sample_indices[:num], others.sample_indices)
    np.testing.assert_array_equal(rows.sample_indices[num:], np.arange(40))
    signed_margins, gradient = rows.signed_margins[num:], rows.gradients[num:]
    np.testing.assert_array_equal(signed_margins >= -1e-6, constraints.are_satisfied(qs))
    # Along a short step the margin changes by the gradient, unless another face becomes nearest.
    direction = rng.normal(size=(40, 6))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    step = 1e-4
    there = both.within(qs + step * direction, FAR).signed_margins[-40:]
    errors = np.abs((there - signed_margins) / step - (gradient * direction).sum(axis=1))
    assert np.median(errors) < 1e-3
    assert (errors < 0.02).sum() >= 38


def test_constraints_with_large_margins_have_no_rows() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    start = world.positions(group)
    wide = PlacedBox(np.array([50.0, 50.0, 50.0]), Pose.identity())
    constraints = PathConstraints.compiled(world, group, (KeepIn(FRAME, wide),), start)
    buffers = DistanceBuffers.from_ends(world, world.margins(), world.embed(group, start[None]))
    bare = make_distance_query(world, group, buffers)
    rows = ConstraintDistanceQuery(bare, constraints, along(group, start)).within(start[None], 0.1)
    assert len(rows.sample_indices) == len(bare.within(start[None], 0.1).sample_indices)


WALLS = [([0.4, 1.0, 0.2], [-0.5, 0.0, 0.0]), ([0.4, 0.6, 0.2], [0.45, 0.0, 0.0])]


def distances(qs: np.ndarray) -> np.ndarray:
    """Return how far a puck is from each of the walls, shape (m, 2)."""
    sides = np.array([size[:2] for size, _ in WALLS]) / 2
    middles = np.array([centre[:2] for _, centre in WALLS])
    beyond = np.maximum(np.abs(qs[:, None] - middles) - sides, 0.0)
    return np.linalg.norm(beyond, axis=2) - 0.02


@pytest.mark.parametrize("kernel", [True, False])
@pytest.mark.parametrize("far", [0.2, np.inf])
def test_a_band_has_margins_to_both_bounds(make_puck, kernel: bool, far: float) -> None:
    world = make_puck(WALLS)
    world = load_world(world.scene, world.library, kernel=kernel)
    group = world.group("puck")
    band = DistanceBand(None, None, 0.05, far)
    (compiled,) = PathConstraints.compiled(world, group, (band,), np.zeros(2)).constraints
    compiled = compiled.tightened(0.004)
    query = BandDistanceQuery(compiled, along(group, np.zeros(2)))
    rng = np.random.default_rng(1)
    qs = rng.uniform([-0.25, -0.9], [0.2, 0.9], (60, 2))
    qs = qs[distances(qs).min(axis=1) > 0.001]
    rows = query.within(qs, 0.3)
    margins = np.full(len(qs), np.inf)
    np.minimum.at(margins, rows.sample_indices, rows.signed_margins)
    nearest = distances(qs).min(axis=1)
    expected = np.minimum(nearest - 0.054, far - 0.004 - nearest)
    is_within = expected < 0.3
    np.testing.assert_allclose(margins[is_within], np.maximum(expected, -0.3)[is_within], atol=1e-6)
    np.testing.assert_array_equal(margins[expected > 1e-6] > 0, True)
    np.testing.assert_array_equal(
        (margins > 0)[np.abs(expected) > 1e-5], compiled.are_satisfied(qs)[np.abs(expected) > 1e-5]
    )
    # Row by row, the gradient predicts the change of the margin by a short step.
    direction = rng.normal(size=2) * 1e-5
    there = query.within(qs + direction, 0.3)
    np.testing.assert_array_equal(there.sample_indices, rows.sample_indices)
    errors = np.abs(there.signed_margins - rows.signed_margins - rows.gradients @ direction)
    assert np.median(errors) < 1e-9
    assert (errors < 1e-7).mean() > 0.95
