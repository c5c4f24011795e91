"""Rules as distances: their gradients are those of what they leave."""

import numpy as np
import pytest

from planning.domain.constraint import KeepIn, KeepOut, OrientationCone, PathConstraint, PlacedBox
from planning.domain.pose import Pose
from planning.refine.buffers import Buffers
from planning.refine.nearness import nearness_of
from planning.refine.ruled_nearness import RuledNearness
from planning.world.rules.path_rules import PathRules
from tests.conftest import bundled_world

FRAME = "arm::tool0"
BOX = PlacedBox(np.array([0.5, 0.4, 0.6]), Pose.from_parts([0.4, 0.1, 0.4], rpy=[0.1, 0.2, 0.3]))
DIRECTION = np.array([0.3, -0.2, 1.0])
FAR = 100.0


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
    rules = PathRules.compiled(world, group, (constraint,), start)
    buffers = Buffers.between(world, world.margins(), world.embed(group, start[None]))
    bare = nearness_of(world, group, buffers)
    near = RuledNearness(bare, rules, np.asarray)
    qs = start + rng.normal(0.0, 0.5, (40, 6))
    seen, others = near.within(qs, FAR), bare.within(qs, FAR)
    num = len(others.at)
    np.testing.assert_array_equal(seen.at[:num], others.at)
    np.testing.assert_array_equal(seen.at[num:], np.arange(40))
    spare, gradient = seen.spare[num:], seen.gradient[num:]
    np.testing.assert_array_equal(spare >= -1e-6, rules.are_kept(qs))
    # Along any short way the room changes as the gradient says, but where a face becomes another.
    way = rng.normal(size=(40, 6))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    step = 1e-4
    there = near.within(qs + step * way, FAR).spare[-40:]
    errors = np.abs((there - spare) / step - (gradient * way).sum(axis=1))
    assert np.median(errors) < 1e-3
    assert (errors < 0.02).sum() >= 38


def test_what_leaves_much_room_is_not_told() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    start = world.positions(group)
    wide = PlacedBox(np.array([50.0, 50.0, 50.0]), Pose.identity())
    rules = PathRules.compiled(world, group, (KeepIn(FRAME, wide),), start)
    buffers = Buffers.between(world, world.margins(), world.embed(group, start[None]))
    bare = nearness_of(world, group, buffers)
    seen = RuledNearness(bare, rules, np.asarray).within(start[None], 0.1)
    assert len(seen.at) == len(bare.within(start[None], 0.1).at)
