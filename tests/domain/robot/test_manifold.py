"""The axioms of plus and minus, on every kind of joint."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from tests.conftest import group_of, random_waypoints

KINDS = [
    (JointType.REVOLUTE, JointType.PRISMATIC),
    (JointType.CONTINUOUS,),
    (JointType.PLANAR,),
    (JointType.FLOATING,),
    (JointType.FLOATING, JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PLANAR),
]


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000))
def test_minus_undoes_plus(kinds: tuple[JointType, ...], seed: int) -> None:
    group = group_of(*kinds)
    manifold = Manifold(group.joints)
    q0, q1 = random_waypoints(group, seed, 2, spread=0.5)
    delta = manifold.minus(q1, q0)
    again = manifold.minus(manifold.plus(q0, delta), q1)
    assert np.abs(again).max() < 1e-9
    assert manifold.distance(q1, q0) == pytest.approx(manifold.distance(q0, q1))


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000), s=st.floats(0, 1))
def test_geodesics_are_shortest_and_even(kinds: tuple[JointType, ...], seed: int, s: float) -> None:
    group = group_of(*kinds)
    manifold = Manifold(group.joints)
    q0, q1 = random_waypoints(group, seed, 2, spread=0.5)
    middle = manifold.interpolate(q0, q1, np.array([s]))[0]
    whole = float(manifold.distance(q1, q0))
    assert float(manifold.distance(middle, q0)) == pytest.approx(s * whole, abs=1e-9)
    assert float(manifold.distance(q1, middle)) == pytest.approx((1 - s) * whole, abs=1e-9)


def test_a_circle_is_crossed_the_short_way() -> None:
    manifold = Manifold(group_of(JointType.CONTINUOUS).joints)
    delta = manifold.minus(np.array([-3.0]), np.array([3.0]))
    assert delta[0] == pytest.approx(2 * np.pi - 6.0)


def test_one_manifold_serves_the_very_same_joints() -> None:
    """However many there are meanwhile, it is that of those joints."""
    groups = [group_of(kind) for _ in range(100) for kinds in KINDS for kind in kinds]
    for group in groups:
        made = Manifold.of(group.joints)
        assert made.joints is group.joints
        assert made is Manifold.of(group.joints)
    assert all(Manifold.of(group.joints).joints is group.joints for group in groups)
