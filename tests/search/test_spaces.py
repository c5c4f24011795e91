"""OMPL's states and metrics are ours."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.joints import JointType
from planning.search.spaces import SearchSpace

KINDS = [
    (JointType.REVOLUTE, JointType.PRISMATIC, JointType.REVOLUTE),
    (JointType.CONTINUOUS,),
    (JointType.PLANAR,),
    (JointType.FLOATING,),
    (JointType.CONTINUOUS, JointType.REVOLUTE, JointType.FLOATING, JointType.PLANAR),
    (JointType.PLANAR, JointType.REVOLUTE, JointType.CONTINUOUS, JointType.REVOLUTE),
]


def random_qs(manifold, rng, count):
    return manifold.normalized(rng.uniform(-1, 1, (count, manifold.num_positions)))


def make(make_group, make_limits, kinds):
    group = make_group(*kinds)
    nq = group.num_positions
    return SearchSpace(group, make_limits(group), np.zeros((1, nq)))


@pytest.mark.parametrize("kinds", KINDS)
def test_states_keep_their_configuration(make_group, make_limits, kinds):
    space = make(make_group, make_limits, kinds)
    for q in random_qs(space.manifold, np.random.default_rng(0), 50):
        back = space.read(space.write(q))
        assert space.manifold.distance(back, q) < 1e-12
        assert space.ompl.satisfiesBounds(space.write(q))


@pytest.mark.parametrize("kinds", KINDS)
def test_metrics_agree_within_the_root_of_the_number_of_parts(make_group, make_limits, kinds):
    space = make(make_group, make_limits, kinds)
    rng = np.random.default_rng(1)
    num_parts = {1: 1, 3: 1, 4: 6, 5: 4}.get(len(kinds), 2)
    if kinds[0] in {JointType.PLANAR, JointType.FLOATING} and len(kinds) == 1:
        num_parts = 2
    if len(kinds) == 4:
        num_parts = 6
    for q0, q1 in zip(
        random_qs(space.manifold, rng, 50), random_qs(space.manifold, rng, 50), strict=True
    ):
        ours = space.manifold.distance(q1, q0)
        theirs = space.ompl.distance(space.write(q0), space.write(q1))
        assert ours <= theirs + 1e-9
        assert theirs <= np.sqrt(num_parts) * ours + 1e-9


@given(st.floats(-30, 30), st.floats(-30, 30))
@settings(max_examples=40, deadline=None)
def test_whole_turns_are_the_same_state(a, b):
    from planning.domain.joints import Joint, JointGroup, JointLimits

    group = JointGroup("r", (Joint("r::j", JointType.CONTINUOUS),), ("t",))
    free, one = np.array([np.inf]), np.ones(1)
    limits = JointLimits(-free, free, one, one, one, one, ((0,),))
    space = SearchSpace(group, limits, np.zeros((1, 1)))
    qa, qb = np.array([a]), np.array([b])
    there = space.ompl.distance(space.write(qa), space.write(qb))
    assert there == pytest.approx(float(space.manifold.distance(qa, qb)), abs=1e-9)


def test_the_turn_of_a_floating_body_is_measured_by_its_angle(make_group, make_limits):
    space = make(make_group, make_limits, (JointType.FLOATING,))
    q0 = np.array([1.0, 0, 0, 0, 0, 0, 0])
    q1 = np.array([np.cos(0.5), np.sin(0.5), 0, 0, 0, 0, 0])
    assert space.ompl.distance(space.write(q0), space.write(q1)) == pytest.approx(1.0)


def test_unlimited_translations_are_searched_near_the_origin_and_the_goals(make_group, make_limits):
    group = make_group(JointType.PLANAR)
    limits = make_limits(group, np.inf)
    space = SearchSpace(group, limits, np.array([[0.0, 25.0, 0.0]]))
    assert space.lower[0] == -10.0
    assert space.upper[0] == 10.0
    assert space.upper[1] == 26.0
    assert np.isinf(space.upper[2])


def test_a_locked_joint_stays_locked(make_group, make_limits):
    group = make_group(JointType.REVOLUTE, JointType.REVOLUTE)
    limits = make_limits(group)
    upper = np.array([1.0, -1.0])
    limits = type(limits)(-np.ones(2), upper, *[limits.velocity] * 4, limits.blocks)
    space = SearchSpace(group, limits, np.zeros((1, 2)))
    state = space.ompl.allocState()
    sampler = space.ompl.allocDefaultStateSampler()
    for _ in range(20):
        sampler.sampleUniform(state)
        assert abs(space.read(state)[1] + 1.0) <= 1e-9
