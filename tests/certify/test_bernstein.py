"""Bernstein bounds enclose, and their peaks are the true ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.certify import bernstein

pytestmark = pytest.mark.usefixtures("implementation")


def polynomials(seed: int, count: int, degree: int, width: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(count, degree + 1, width))


@given(st.integers(0, 9999), st.integers(1, 9))
def test_values_lie_between_the_coefficients(seed: int, degree: int) -> None:
    power = polynomials(seed, 3, degree, 2)
    widths = np.array([0.5, 1.0, 2.0])
    bounds = bernstein.from_power(power, widths)
    for i, width in enumerate(widths):
        x = np.linspace(0, width, 101)[:, None] ** np.arange(degree + 1)
        values = x @ power[i]
        assert (values <= bounds[i].max(axis=0) + 1e-9).all()
        assert (values >= bounds[i].min(axis=0) - 1e-9).all()
        assert values[0] == pytest.approx(bounds[i, 0])
        assert values[-1] == pytest.approx(bounds[i, -1])


@given(st.integers(0, 9999), st.integers(1, 8))
def test_peaks_are_reached(seed: int, degree: int) -> None:
    power = polynomials(seed, 4, degree, 1)
    top, row, fraction = bernstein.peak(bernstein.from_power(power, np.ones(4))[:, :, 0], 1e-9)
    x = np.linspace(0, 1, 2001)[:, None] ** np.arange(degree + 1)
    sampled = (power[:, :, 0] @ x.T).max()
    assert sampled - 1e-9 <= top <= sampled + 1e-3
    there = (fraction ** np.arange(degree + 1)) @ power[row, :, 0]
    assert there == pytest.approx(top, abs=1e-3)


@given(st.integers(0, 9999), st.integers(0, 5))
def test_square_norms_are_the_polynomials_of_the_norm(seed: int, degree: int) -> None:
    power = polynomials(seed, 2, degree, 3)
    squares = bernstein.square_norm(bernstein.from_power(power, np.ones(2)))
    left, right = bernstein.halves(squares[..., None])
    middle = (0.5 ** np.arange(degree + 1)) @ power
    assert left[:, -1, 0] == pytest.approx((middle**2).sum(axis=-1))
    assert right[:, 0, 0] == pytest.approx((middle**2).sum(axis=-1))
