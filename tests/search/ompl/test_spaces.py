"""OMPL's states and metrics are ours."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.search.ompl.spaces import SearchSpace
from tests.profiles import num_cases

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
@settings(max_examples=num_cases(6))
def test_whole_turns_are_the_same_state(a, b):
    from planning.domain.robot.joints import Joint, JointGroup, JointLimits

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


def weighed(make_group, make_limits, kinds, held=()):
    group = make_group(*kinds)
    weights = np.linspace(0.4, 2.5, len(group.blocks))
    anchors = random_qs(Manifold(group.joints), np.random.default_rng(9), 1)
    return SearchSpace(group, make_limits(group), anchors, weights, held)


@pytest.mark.parametrize("kinds", KINDS)
@pytest.mark.parametrize("is_weighed", [False, True])
@given(seed=st.integers(0, 10_000), share=st.floats(0.0, 1.0))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=num_cases(6))
def test_ompl_interpolates_on_our_geodesics_within_bounds(
    make_group, make_limits, kinds, is_weighed, seed, share
):
    """OMPL's interpolation between two states is the edge that is checked."""
    build = weighed if is_weighed else make
    space = build(make_group, make_limits, kinds)
    q0, q1 = random_qs(space.manifold, np.random.default_rng(seed), 2)
    a, b, between = space.write(q0), space.write(q1), space.ompl.allocState()
    space.ompl.interpolate(a, b, share, between)
    ours = space.manifold.interpolate(q0, q1, np.array([share]))[0]
    theirs = space.read(between)
    assert float(space.manifold.distance(ours, theirs)) < 1e-6
    assert space.ompl.satisfiesBounds(between)
    assert space.contains(theirs[None])[0]
    whole = space.ompl.distance(a, b)
    # OMPL calls rotations the same whose quaternions' product is within 1e-9 of one (9e-5 rad).
    dust = 1e-6 if JointType.FLOATING not in kinds else 3e-4
    assert space.ompl.distance(a, between) == pytest.approx(share * whole, abs=dust)
    assert space.ompl.distance(between, b) == pytest.approx((1 - share) * whole, abs=dust)
    length = float(space.manifold.distance(q1, q0))
    assert float(space.manifold.distance(ours, q0)) == pytest.approx(share * length, abs=1e-6)


@pytest.mark.parametrize("kinds", KINDS)
def test_samples_are_configurations_within_bounds(make_group, make_limits, kinds):
    space = weighed(make_group, make_limits, kinds)
    state = space.ompl.allocState()
    sampler = space.ompl.allocDefaultStateSampler()
    for _ in range(20):
        sampler.sampleUniform(state)
        q = space.read(state)
        assert space.contains(q[None])[0]
        assert float(space.manifold.distance(space.manifold.normalized(q), q)) < 1e-9
        # Whole turns and the sign of a quaternion aside it is that very state again.
        assert space.ompl.distance(space.write(q), state) < 1e-7
        assert float(space.manifold.distance(space.read(space.write(q)), q)) < 1e-9


def test_weights_stretch_the_metric(make_group, make_limits):
    kinds = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PLANAR, JointType.FLOATING)
    group = make_group(*kinds)
    weights = np.array([3.0, 0.5, 2.0, 4.0, 0.25, 5.0])
    q0 = np.array([0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0.0])
    space = SearchSpace(group, make_limits(group), q0[None], weights)
    steps = [(0, 3.0), (1, 0.5), (2, 2.0), (3, 2.0), (4, 4.0), (5, 0.25), (8, 5.0)]
    for iv, factor in steps:
        delta = np.zeros(group.num_velocities)
        delta[iv] = 0.3
        there = space.manifold.plus(q0, delta)
        distance = space.ompl.distance(space.write(q0), space.write(there))
        assert distance == pytest.approx(0.3 * factor, abs=1e-7)


@pytest.mark.parametrize(
    ("kinds", "held"),
    [
        ((JointType.PLANAR,), [2]),
        ((JointType.FLOATING,), [0, 1, 2, 3]),
        ((JointType.CONTINUOUS, JointType.FLOATING, JointType.PLANAR), [1, 2, 3, 4, 10]),
    ],
)
def test_held_rotations_are_no_dimensions(make_group, make_limits, kinds, held):
    space = weighed(make_group, make_limits, kinds, held)
    rest = random_qs(space.manifold, np.random.default_rng(9), 1)[0]
    assert space.ompl.getDimension() == space.manifold.num_velocities - len(held) + sum(
        kind is JointType.FLOATING for kind in kinds
    )
    state = space.ompl.allocState()
    sampler = space.ompl.allocDefaultStateSampler()
    for _ in range(10):
        sampler.sampleUniform(state)
        q = space.read(state)
        assert q[held].tolist() == pytest.approx(rest[held].tolist())
        assert space.contains(q[None])[0]
    turned = random_qs(space.manifold, np.random.default_rng(3), 1)[0]
    assert not space.contains(turned[None])[0]


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
