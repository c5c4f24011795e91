"""A few weights of control points are the spline and its derivatives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.refine.curves import bspline_basis
from planning.refine.curves.bspline_basis import (
    basis_weights,
    even_positions,
    greville_abscissae,
    make_bspline,
    num_spans,
    position_weights,
)
from tests.profiles import num_cases

COUNTS = st.integers(5, 20)
SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=num_cases(6))
@given(count=COUNTS, seed=SEEDS, order=st.integers(0, 3))
def test_weighted_sums_are_drakes_derivatives(count, seed, order):
    rng = np.random.default_rng(seed)
    points, s = rng.uniform(-3, 3, (count, 4)), np.append(rng.uniform(0, 1, 30), [0.0, 1.0])
    spline = make_bspline(points)
    wanted = (spline.MakeDerivative(order) if order else spline).vector_values(s).T
    found = basis_weights(count, s, order).apply(points)
    np.testing.assert_allclose(found, wanted, atol=1e-8 * max(1.0, np.abs(wanted).max()))


@settings(max_examples=num_cases(6))
@given(count=COUNTS, seed=SEEDS)
def test_the_third_derivative_at_a_knot_is_that_of_the_span_asked_for(count, seed):
    points = np.random.default_rng(seed).uniform(-3, 3, (count, 2))
    spans = np.arange(num_spans(count))
    low, high = spans / num_spans(count), (spans + 1) / num_spans(count)
    at_low, middle, at_high = (
        basis_weights(count, s, 3, spans).apply(points) for s in (low, (low + high) / 2, high)
    )
    scale = np.abs(middle).max()
    np.testing.assert_allclose(at_low, middle, atol=1e-6 * scale)
    np.testing.assert_allclose(at_high, middle, atol=1e-6 * scale)


@given(count=COUNTS)
def test_control_points_at_their_centres_make_the_identity(count):
    s = np.linspace(0, 1, 23)
    found = basis_weights(count, s).apply(greville_abscissae(count)[:, None])[:, 0]
    assert found == pytest.approx(s, abs=1e-11)


@pytest.mark.parametrize("kernel", [True, False])
@given(count=st.integers(4, 28), seed=SEEDS, num_intervals=st.integers(1, 60))
def test_positions_are_drakes_with_and_without_the_kernel(kernel, count, seed, num_intervals):
    rng = np.random.default_rng(seed)
    points, s = rng.uniform(-3, 3, (count, 4)), np.linspace(0, 1, num_intervals + 1)
    wanted = make_bspline(points).vector_values(s).T
    with pytest.MonkeyPatch.context() as patch:
        if not kernel:
            patch.setattr(bspline_basis, "native", lambda: None)
        weights, even = position_weights(count, s), even_positions(points, num_intervals)
    np.testing.assert_allclose(weights.apply(points), wanted, atol=1e-9)
    np.testing.assert_allclose(even, wanted, atol=1e-9)
    np.testing.assert_array_equal(even[[0, -1]], points[[0, -1]])
    np.testing.assert_array_equal(
        weights.control_points[:, 0].clip(0, count - 4), weights.control_points[:, 0]
    )
