"""Bounds on angular rates hold, and are tight."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.certify.intervals import bernstein
from planning.certify.intervals.angular_rates import angular_peak, velocity_series
from planning.certify.intervals.quaternion_series import quaternion_angular_velocity
from planning.certify.intervals.taylor import skew
from planning.domain.geometry import rotation

pytestmark = pytest.mark.drake_only


def sampled_rates(coefficients: np.ndarray, width: float) -> list[np.ndarray]:
    """Return |omega|, |alpha| and |jerk| on a grid, the first from quaternions alone."""
    t = np.linspace(0, width, 4001)

    def tangent(order: int) -> np.ndarray:
        power = bernstein.derivative(coefficients[None], order)[0]
        return (t[:, None] ** np.arange(len(power))) @ power

    turned = rotation.exp(tangent(0))
    step = t[1] - t[0]
    between = rotation.log(rotation.multiply(rotation.conjugate(turned[:-1]), turned[1:])) / step
    alpha = rotation.body_acceleration(tangent(0), tangent(1), tangent(2))
    jerk = np.gradient(alpha, step, axis=0)[1:-1]
    return [np.linalg.norm(rate, axis=1) for rate in (between, alpha, jerk)]


@given(seed=st.integers(0, 10_000), degree=st.integers(1, 6), size=st.floats(0.05, 1.5))
def test_bounds_are_above_the_samples_and_near_them(seed: int, degree: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(0.0, size, (degree + 1, 3))
    width = float(rng.uniform(0.3, 1.0))
    for order, rates in enumerate(sampled_rates(coefficients, width), start=1):
        bound, piece, fraction = angular_peak(
            coefficients[None], np.array([width]), order, tolerance=1e-6
        )
        peak = float(rates.max())
        assert bound >= peak * (1 - 1e-5) - 1e-6
        assert bound == pytest.approx(peak, rel=0.02, abs=0.02)
        assert piece == 0
        assert 0 <= fraction <= 1


def test_the_piece_of_the_peak_is_named() -> None:
    coefficients = np.random.default_rng(0).normal(0.0, 0.3, (3, 4, 3))
    coefficients[1] *= 3
    _, piece, fraction = angular_peak(coefficients, np.array([0.5, 1.0, 0.5]), 2, 1e-6)
    assert piece == 1
    assert 0 <= fraction <= 1


def test_a_rotation_about_one_axis_has_the_tangents_rates() -> None:
    axis = np.array([1.0, 2.0, 2.0]) / 3
    coefficients = (np.array([0.3, 1.0, 0.5, -0.2])[:, None] * axis)[None]
    bound, _, _ = angular_peak(coefficients, np.ones(1), 1, 1e-8)
    assert bound == pytest.approx(1.0 + 2 * 0.5 * (5 / 6) - 0.6 * (5 / 6) ** 2, abs=1e-6)


def test_a_rotation_of_many_turns_at_constant_rate_has_no_acceleration() -> None:
    coefficients = np.array([[[0.0, 0.0, 0.0], [40.0, 1.0, 0.0]]])
    assert angular_peak(coefficients, np.ones(1), 2, 1e-6)[0] == pytest.approx(0, abs=1e-5)


@given(seed=st.integers(0, 10_000), far=st.floats(3.0, 60.0))
def test_large_rotations_are_bounded_tightly(seed: int, far: float) -> None:
    """About a moving axis, between two angles of many whole turns."""
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(0.0, 1.0, (5, 3))
    coefficients[0] *= far / np.linalg.norm(coefficients[0])
    coefficients[1] *= rng.uniform(0.1, 1.0) * far / np.linalg.norm(coefficients[1])
    for order, rates in enumerate(exact_rates(coefficients), start=1):
        bound, _, fraction = angular_peak(coefficients[None], np.ones(1), order, tolerance=1e-6)
        assert bound >= rates.max() * (1 - 1e-9)
        assert bound <= rates.max() * 1.01
        assert 0 <= fraction <= 1


def exact_rates(coefficients: np.ndarray) -> list[np.ndarray]:
    """Return |omega| and |alpha| on a grid, by the formulas of the right Jacobian."""
    t = np.linspace(0, 1, 4001)
    powers = [bernstein.derivative(coefficients[None], order)[0] for order in range(3)]
    delta, rate, change = ((t[:, None] ** np.arange(len(power))) @ power for power in powers)
    omega = rotation.right_jacobian(delta, rate)
    alpha = rotation.body_acceleration(delta, rate, change)
    return [np.linalg.norm(found, axis=1) for found in (omega, alpha)]


@given(seed=st.integers(0, 10_000), angle=st.floats(1.5, 4.5))
def test_both_series_of_angular_velocity_agree(seed: int, angle: float) -> None:
    delta = np.random.default_rng(seed).normal(size=(1, 9, 3))
    delta[:, 0] *= angle / np.linalg.norm(delta[:, 0])
    summed = velocity_series(skew(delta), delta, -1.0)
    np.testing.assert_allclose(
        quaternion_angular_velocity(delta), summed, rtol=0, atol=1e-9 * np.abs(summed).max()
    )
    sizes = np.linalg.norm(delta, axis=2)[:, :, None]
    sizes[:, 0] = 0.0
    most = velocity_series(sizes[..., None], sizes, 1.0)[..., 0]
    assert (np.linalg.norm(summed, axis=2) <= most * (1 + 1e-12)).all()
