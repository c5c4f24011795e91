"""Ranking: duplicates among IK solutions, and their equivalents by full turns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.robot.joints import JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.goals.ranking import UniqueSolutions, full_turn_equivalents
from planning.kernel.native import native
from tests.conftest import group_of
from tests.profiles import num_cases

KINDS = (
    JointType.REVOLUTE,
    JointType.CONTINUOUS,
    JointType.PRISMATIC,
    JointType.PLANAR,
    JointType.FLOATING,
)


@given(
    seed=st.integers(0, 2**32 - 1),
    kinds=st.lists(st.sampled_from(KINDS), min_size=1, max_size=4),
    num_places=st.integers(1, 12),
)
@settings(max_examples=num_cases(6))
def test_rows_are_new_unless_they_repeat_one_before(
    seed: int, kinds: list[JointType], num_places: int
) -> None:
    """Places are far apart; each row is one of them, with dust and whole turns."""
    rng = np.random.default_rng(seed)
    group = group_of(*kinds)
    manifold = Manifold(group.joints)
    zero = np.zeros(group.num_positions)
    turning = np.zeros(group.num_positions)
    begin = 0
    for joint in group.joints:
        zero[begin] = 1.0 if joint.type is JointType.FLOATING else 0.0
        if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
            turning[begin] = 1.0
        if joint.type is JointType.PLANAR:
            turning[begin + 2] = 1.0
        begin += joint.num_positions
    places = manifold.plus(zero[None], rng.normal(size=(num_places, manifold.num_velocities)))
    choice, targets = rng.integers(num_places, size=40), rng.integers(2, size=40)
    dust = rng.uniform(-1e-4, 1e-4, (40, manifold.num_velocities))
    rows = manifold.plus(places[choice], dust)
    rows += turning * 2 * np.pi * rng.integers(-1, 2, rows.shape)
    distinct = UniqueSolutions(group, manifold)
    seen: set[tuple[int, int]] = set()
    for part in np.array_split(np.arange(40), 3):
        are_new = distinct.are_new(rows[part], targets[part])
        distinct.add(rows[part][are_new], targets[part][are_new])
        for i, is_new in zip(part, are_new, strict=True):
            place = int(choice[i]), int(targets[i])
            assert is_new == (place not in seen)
            seen.add(place)
    assert len(distinct) == len(seen)


@pytest.mark.skipif(native() is None, reason="the native kernel is not built")
@given(seed=st.integers(0, 2**32 - 1), num_joints=st.integers(1, 7), count=st.integers(1, 60))
@settings(max_examples=num_cases(20))
def test_the_kernel_finds_the_same_duplicates(seed: int, num_joints: int, count: int) -> None:
    """Rows are so dense that chains of duplicates form, some of them across a full turn."""
    rng = np.random.default_rng(seed)
    kinds = rng.choice(np.array([JointType.REVOLUTE, JointType.PRISMATIC]), num_joints)
    group = group_of(*(JointType(kind) for kind in kinds))
    distinct = UniqueSolutions(group, Manifold(group.joints))
    rows = rng.uniform(-1, 1, (count, num_joints)) * rng.choice([1e-3, 4e-3, 2e-2])
    rows += 2 * np.pi * rng.integers(-1, 2, rows.shape) * (kinds == JointType.REVOLUTE)
    targets = rng.integers(2, size=count)
    np.testing.assert_array_equal(
        distinct.are_new(rows, targets), distinct.are_first_in_numpy(rows, targets)
    )


def test_limits_shorter_than_a_turn_leave_each_row_alone() -> None:
    group = group_of(JointType.REVOLUTE, JointType.PRISMATIC)
    rows = np.array([[3.0, 0.5], [-3.0, -0.5], [0.1, 0.0]])
    for reach, count in ((3.1, 3), (np.pi + 1, 5)):
        limits = JointLimits(np.full(2, -reach), np.full(2, reach), *np.ones((4, 2)), ((0,), (1,)))
        found, index = full_turn_equivalents(group, limits, rows)
        assert len(found) == len(index) == count
        np.testing.assert_allclose(np.remainder(found - rows[index] + 1, 2 * np.pi), 1.0)
