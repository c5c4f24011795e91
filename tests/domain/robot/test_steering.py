"""Arcs as geodesics, and the polynomials that stand for them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import SteeredGroup, Steering, manifold_of, steered
from tests.conftest import group_of, random_waypoints

KINDS = [
    (JointType.PLANAR,),
    (JointType.REVOLUTE, JointType.PLANAR, JointType.PRISMATIC),
    (JointType.FLOATING, JointType.PLANAR, JointType.CONTINUOUS),
]


def car_group(*kinds: JointType) -> JointGroup:
    group = group_of(*kinds)
    name = next(joint.name for joint in group.joints if joint.type is JointType.PLANAR)
    return steered(group, {name: Steering(0.5)})


def place(group: JointGroup) -> tuple[int, int]:
    return manifold_of(group).offsets[0]


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000))
def test_minus_undoes_plus(kinds: tuple[JointType, ...], seed: int) -> None:
    group = car_group(*kinds)
    manifold = manifold_of(group)
    q0, q1 = random_waypoints(group, seed, 2, spread=0.8)
    delta = manifold.minus(q1, q0)
    assert np.abs(manifold.minus(manifold.plus(q0, delta), q1)).max() < 1e-9
    assert manifold.distance(q1, q0) == pytest.approx(manifold.distance(q0, q1))


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000), s=st.floats(0, 1))
def test_geodesics_are_even(kinds: tuple[JointType, ...], seed: int, s: float) -> None:
    manifold = manifold_of(car_group(*kinds))
    q0, q1 = random_waypoints(group_of(*kinds), seed, 2, spread=0.5)
    middle = manifold.interpolate(q0, q1, np.array([s]))[0]
    whole = float(manifold.distance(q1, q0))
    assert manifold.distance(middle, q0) == pytest.approx(s * whole, abs=1e-9)
    assert manifold.distance(q1, middle) == pytest.approx((1 - s) * whole, abs=1e-9)


@given(
    yaw=st.floats(-3, 3),
    turn=st.floats(-2.5, 2.5),
    ahead=st.floats(-2, 2),
    scale=st.sampled_from([1.0, 1e-3, 1e-6]),
)
def test_a_car_rolls_along_its_circle(yaw: float, turn: float, ahead: float, scale: float) -> None:
    """Every place is at the same distance from the centre, which is beside the rear axle."""
    manifold = manifold_of(car_group(JointType.PLANAR))
    q0, delta = np.array([0.3, -0.2, yaw]), scale * np.array([ahead, 0.0, turn])
    qs = manifold.plus(q0, np.linspace(0, 1, 7)[:, None] * delta)
    # Cross-multiplied by the turn, a line is a circle as well.
    aside = np.stack([-np.sin(qs[:, 2]), np.cos(qs[:, 2])], axis=1)
    centres = delta[2] * qs[:, :2] + delta[0] * aside
    assert np.abs(centres - centres[0]).max() < 1e-14


@pytest.mark.parametrize("kinds", KINDS)
@given(seed=st.integers(0, 10_000))
def test_polynomials_follow_the_arcs(kinds: tuple[JointType, ...], seed: int) -> None:
    """To a billionth of their length, where they are and where they head."""
    group = car_group(*kinds)
    manifold = manifold_of(group)
    iq, iv = place(group)
    rng = np.random.default_rng(seed)
    rows = [random_waypoints(group, seed, 1)[0]]
    for _ in range(4):
        delta = rng.uniform(-0.3, 0.3, group.num_velocities)
        delta[iv : iv + 3] = rng.uniform(-1, 1), 0.0, rng.choice([0.0, 1.9, -0.7])
        rows.append(manifold.plus(rows[-1], delta))
    path = JointPath(group, np.array(rows))
    spline = path.spline
    lengths = manifold.distance(path.waypoints[1:], path.waypoints[:-1])
    ends = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    for i in range(4):
        inside = np.linspace(0.01, 0.99, 23)
        s = ends[i] + inside * (ends[i + 1] - ends[i])
        wanted = manifold.interpolate(*path.waypoints[i : i + 2], inside)
        plain = Manifold(group.joints)
        assert plain.distance(spline.positions(s), wanted).max() < 1e-8
        yaw, rates = wanted[:, iq + 2], spline.velocities(s)[:, iv : iv + 2]
        aside = np.cos(yaw) * rates[:, 1] - np.sin(yaw) * rates[:, 0]
        assert np.abs(aside).max() < 1e-6 * np.linalg.norm(rates, axis=1).min()
    assert np.abs(spline.positions(ends) - path.waypoints).max() < 1e-12
    assert path.length == pytest.approx(lengths.sum())


def test_a_group_without_cars_is_the_plain_one() -> None:
    group = group_of(JointType.PLANAR)
    assert steered(group, {}) == group
    assert isinstance(car_group(JointType.PLANAR), SteeredGroup)
    tighter = replace(car_group(JointType.PLANAR), steering={"g::j0": Steering(0.4)})
    assert tighter != car_group(JointType.PLANAR)
