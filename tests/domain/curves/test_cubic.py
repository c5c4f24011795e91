"""Cubic splines: through the waypoints, twice continuously differentiable, of fourth order."""

import numpy as np
import pytest

from planning.domain.curves.cubic import cubic_through
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from tests.conftest import group_of


def test_it_meets_waypoints_and_its_second_derivative_does_not_jump() -> None:
    rng = np.random.default_rng(3)
    joints = group_of(JointType.REVOLUTE, JointType.CONTINUOUS).joints
    x = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.1, 0.9, 6)]))
    q = np.cumsum(rng.normal(0, 0.4, (8, 2)), axis=0)
    spline = cubic_through(joints, x, q)
    np.testing.assert_allclose(spline.positions(x), q, atol=1e-12)
    for order in (1, 2):
        before, after = (spline.tangents(x[1:-1] + e, order) for e in (-1e-9, 1e-9))
        np.testing.assert_allclose(before, after, rtol=1e-5, atol=1e-4)


def test_halving_the_steps_makes_the_error_about_sixteen_times_smaller() -> None:
    joints = group_of(JointType.REVOLUTE).joints
    dense = np.linspace(0, 1, 1001)
    errors = []
    for count in (9, 17, 33):
        x = np.linspace(0, 1, count)
        spline = cubic_through(joints, x, np.sin(5 * x)[:, None])
        errors.append(np.abs(spline.positions(dense)[:, 0] - np.sin(5 * dense)).max())
    assert errors[0] / errors[1] > 10
    assert errors[1] / errors[2] > 10


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_turning_body_keeps_its_waypoints(count: int) -> None:
    joints = group_of(JointType.FLOATING).joints
    manifold = Manifold(joints)
    q0 = manifold.normalized(np.array([0.3, -0.5, 0.7, 0.2, 1.0, 2.0, 3.0]))
    x = np.linspace(0, 1, count)
    q = manifold.plus(q0[None], x[:, None] * np.array([0.9, -1.2, 0.4, 0.1, 0.2, 0.3]))
    spline = cubic_through(joints, x, q)
    assert manifold.distance(spline.positions(x), q).max() < 1e-12
