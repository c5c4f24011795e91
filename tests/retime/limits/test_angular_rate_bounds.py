"""Angular rates: bounds hold against finite differences of Drake's own velocities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointType
from planning.retime.limits.angular_rate_bounds import (
    has_moving_axis,
    rate_bounds,
    with_derivatives,
)

JOINTS = (Joint("g::body", JointType.FLOATING),)


def turning_curve(seed: int, width: float) -> TimedTrajectory:
    rng = np.random.default_rng(seed)
    coefficients = np.zeros((1, 5, 6))
    coefficients[0, :, :3] = rng.normal(0.0, 0.6, (5, 3))
    base = np.array([[1.0, 0, 0, 0, 0, 0, 0]])
    return TimedTrajectory(JOINTS, np.array([0.0, width]), base, coefficients)


@pytest.mark.parametrize("order", [1, 2, 3])
@given(seed=st.integers(0, 10_000), width=st.floats(0.05, 1.0))
def test_no_rate_exceeds_its_bound(order: int, seed: int, width: float) -> None:
    curve = turning_curve(seed, width)
    times = np.linspace(0, width, 400)
    if order == 1:
        rates = curve.velocities(times)[:, :3]
    elif order == 2:
        rates = curve.accelerations(times)[:, :3]
    else:
        h = 1e-5
        inner = times[1:-1]
        after, before = curve.accelerations(inner + h), curve.accelerations(inner - h)
        rates = (after - before)[:, :3] / (2 * h)
    peak = float(np.linalg.norm(rates, axis=1).max())
    widths = np.array([width])
    polynomials = with_derivatives(curve.coefficients[:, :, :3], widths, order)
    upper, attained = rate_bounds(polynomials, widths, order)
    slack = 1e-6 * (1 + peak)
    assert peak <= upper[0] + slack
    if order < 3:
        assert attained[0] <= peak + slack


def test_bounds_close_in_on_short_intervals() -> None:
    curve = turning_curve(3, 1.0)
    gaps = []
    for width in (1e-1, 1e-2, 1e-3):
        widths = np.array([width])
        polynomials = with_derivatives(curve.coefficients[:, :, :3], widths, 3)
        upper, attained = rate_bounds(polynomials, widths, 3)
        gaps.append(float(upper[0] / attained[0] - 1))
    assert gaps[2] < 1e-4 < gaps[0]
    assert gaps[1] < gaps[0] / 10


def test_fixed_and_moving_axes_are_distinguished() -> None:
    axis = np.array([0.3, -0.4, 0.5])
    straight = np.array([0.1, 2.0, -1.0])[:, None] * axis
    bent = straight + np.array([[0, 0, 0], [0, 0, 0], [1e-6, 0, 0]])
    assert has_moving_axis(np.stack([straight, bent])).tolist() == [False, True]
