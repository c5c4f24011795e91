"""Distances and their gradients: the kernel's, Drake's and finite differences agree."""

from collections.abc import Callable

import numpy as np
import pytest

from planning.domain.robot.joints import JointGroup
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.refine.constraints.distance_query import DistanceQuery, make_distance_query
from planning.world.loading.load_world import load_world
from planning.world.world import World
from tests.profiles import num_cases

REACH = 0.15
BOTH = pytest.mark.parametrize("kernel", [True, False])


@pytest.fixture(params=[("panda_shelf", 0), ("ur5e_pickup", 0), ("ur5e_pickup", 1)])
def place(request: pytest.FixtureRequest, world_of: Callable[[str], World]):
    name, which = request.param
    world = world_of(name)
    return world, sorted(world.groups, key=lambda group: group.name)[which]


def distance_query_of(world: World, group: JointGroup, *, kernel: bool) -> DistanceQuery:
    chosen = load_world(world.scene, world.library, kernel=kernel)
    return make_distance_query(chosen, group, DistanceBuffers(chosen.margins()))


def configurations(world: World, group: JointGroup, count: int) -> np.ndarray:
    limits = world.limits(group)
    rng = np.random.default_rng(7)
    low, high = np.maximum(limits.lower, -3), np.minimum(limits.upper, 3)
    return rng.uniform(low, high, (count, len(low)))


def least(query: DistanceQuery, qs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest signed margin of every configuration, and its gradient."""
    near = query.within(qs, REACH)
    margins, gradients = np.full(len(qs), REACH), np.zeros_like(qs)
    for i in range(len(qs)):
        rows = np.flatnonzero(near.sample_indices == i)
        if len(rows):
            row = rows[np.argmin(near.signed_margins[rows])]
            margins[i], gradients[i] = near.signed_margins[row], near.gradients[row]
    return margins, gradients


def test_the_kernel_and_drake_find_the_same_nearest_pairs(place):
    world, group = place
    qs = configurations(world, group, 40)
    ours, slopes = least(distance_query_of(world, group, kernel=True), qs)
    theirs, other_slopes = least(distance_query_of(world, group, kernel=False), qs)
    # Shapes that overlap deeply may have several separations of nearly the same depth.
    apart = ours > -0.001
    assert apart.any()
    np.testing.assert_allclose(ours[apart], theirs[apart], atol=2e-5)
    differs = np.abs(slopes - other_slopes)[apart].max(axis=1)
    assert np.mean(differs < 1e-3) > 0.9
    assert (theirs[~apart] < 0).all()


@pytest.mark.parametrize("step", [0.002, 0.05, 1.0])
def test_pairs_that_rest_between_configurations_are_not_lost(place, step):
    # Configurations alone have none before them from which a pair could be known to be far.
    world, group = place
    query = distance_query_of(world, group, kernel=True)
    rng = np.random.default_rng(9)
    first, *others = configurations(world, group, num_cases(6))
    limits = world.limits(group)
    low, high = np.maximum(limits.lower, -3), np.minimum(limits.upper, 3)
    for start in [first, *others]:
        moves = rng.normal(scale=step, size=(80, len(start)))
        qs = np.clip(start + np.cumsum(moves, axis=0), low, high)
        together = query.within(qs, REACH)
        alone = [query.within(q[None], REACH) for q in qs]
        counts = [len(rows.signed_margins) for rows in alone]
        np.testing.assert_array_equal(
            together.sample_indices, np.repeat(np.arange(len(qs)), counts)
        )
        margins = np.concatenate([rows.signed_margins for rows in alone])
        # Of shapes that overlap, the depth depends on the direction from which it is sought.
        apart = margins > 0
        np.testing.assert_allclose(together.signed_margins[apart], margins[apart], atol=1e-8)


@BOTH
def test_the_gradient_is_the_slope(place, kernel):
    world, group = place
    query = distance_query_of(world, group, kernel=kernel)
    qs = configurations(world, group, 25)
    margins, gradients = least(query, qs)
    qs, gradients = (rows[(margins > 1e-3) & (margins < REACH - 1e-3)] for rows in (qs, gradients))
    direction = np.random.default_rng(8).normal(size=qs.shape)
    h = 1e-5
    slopes = (least(query, qs + h * direction)[0] - least(query, qs - h * direction)[0]) / (2 * h)
    assert len(qs) > 2
    # Where the nearest pair or feature changes there is no slope.
    assert np.mean(np.abs(slopes - (gradients * direction).sum(axis=1)) < 2e-3) > 0.8


@BOTH
def test_the_gradient_leads_out_of_collisions(kernel, world_of):
    world = world_of("panda_shelf")
    group = min(world.groups, key=lambda group: group.name)
    query = distance_query_of(world, group, kernel=kernel)
    qs = configurations(world, group, 60)
    margins, gradients = least(query, qs)
    qs, gradients, margins = (rows[margins < -1e-3] for rows in (qs, gradients, margins))
    near = query.within(qs, REACH)
    steps = 1e-4 * gradients / np.linalg.norm(gradients, axis=1, keepdims=True)
    moved = query.within(qs + steps, REACH)
    deepest = [near.signed_margins[near.sample_indices == i].min() for i in range(len(qs))]
    after = [moved.signed_margins[moved.sample_indices == i].min() for i in range(len(qs))]
    assert len(qs) > 5
    assert np.mean(np.array(after) > np.array(deepest)) > 0.9


@BOTH
def test_pairs_that_the_group_does_not_move_are_left_out(make_puck, kernel):
    wall = ([0.2, 0.2, 0.2], [0.0, 0.0, 0.0])
    world = make_puck([wall, ([0.2, 0.2, 0.02], [3.0, 0.0, -0.0301])], idle=[3.0, 0.0, 0.0])
    query = distance_query_of(world, world.group("puck"), kernel=kernel)
    near = query.within(np.array([[-0.15, 0.0], [0.9, 0.9]]), REACH)
    np.testing.assert_array_equal(near.sample_indices, [0])
    required = DistanceBuffers(world.margins()).threshold("puck::puck", "wall0")
    assert near.signed_margins[0] == pytest.approx(0.05 - 0.02 - required, abs=1e-6)
    np.testing.assert_allclose(near.gradients, [[-1.0, 0.0]], atol=1e-6)


@BOTH
def test_nothing_near_is_nothing(make_puck, kernel):
    world = make_puck([])
    near = distance_query_of(world, world.group("puck"), kernel=kernel).within(
        np.zeros((3, 2)), REACH
    )
    assert near.sample_indices.shape == (0,)
    assert near.gradients.shape == (0, 2)
