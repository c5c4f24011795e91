"""Bernstein bounds enclose the values, and their peaks are the true ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.certify.intervals import bernstein
from planning.kernel.native import native

pytestmark = pytest.mark.drake_only

NATIVELY = pytest.mark.parametrize("natively", [True, False])


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


@NATIVELY
@pytest.mark.parametrize("tolerance", [1e-9, 1e-3, 0.3])
@given(seed=st.integers(0, 9999), degree=st.integers(1, 8))
def test_peaks_are_reached(natively: bool, tolerance: float, seed: int, degree: int) -> None:
    power = polynomials(seed, 4, degree, 1)
    forms = bernstein.from_power(power, np.ones(4))[:, :, 0]
    top, row, fraction = bernstein.peak(forms, tolerance, use_kernel=natively)
    x = np.linspace(0, 1, 2001)[:, None] ** np.arange(degree + 1)
    sampled = (power[:, :, 0] @ x.T).max()
    assert sampled - 1e-9 <= top <= sampled + tolerance + 1e-3
    there = (fraction ** np.arange(degree + 1)) @ power[row, :, 0]
    if tolerance < 1e-3:
        assert there == pytest.approx(top, abs=1e-3)


@NATIVELY
@pytest.mark.parametrize("tolerance", [1e-7, 1e-3, 0.1])
@given(seed=st.integers(0, 9999))
def test_the_bound_holds_within_the_tolerance(natively: bool, tolerance: float, seed: int) -> None:
    """The highest of three peaks is flat and not at an end, where others are higher."""
    rng = np.random.default_rng(seed)
    peaks = rng.uniform(0.4, 0.6, 3)
    heights = 1 - np.array([0.0, 0.2, rng.uniform(0.7, 1.0)]) * tolerance
    bends = np.array([2 * tolerance, 0.0, rng.uniform(2.0, 20.0)])
    power = np.stack([heights - bends * peaks**2, 2 * bends * peaks, -bends], axis=1)
    forms = bernstein.from_power(power[:, :, None], np.ones(3))[:, :, 0]
    bound, _, _ = bernstein.peak(forms, tolerance, use_kernel=natively)
    assert 1.0 - 1e-12 <= bound <= 1.0 + tolerance + 1e-12


@NATIVELY
@pytest.mark.parametrize("row", [0, 1])
@pytest.mark.parametrize("column", [0, 1, 3])
def test_what_is_no_number_is_below_no_bound(natively: bool, row: int, column: int) -> None:
    forms = np.zeros((2, 4))
    forms[row, column] = np.nan
    bound, _, _ = bernstein.peak(forms, 1e-9, use_kernel=natively)
    assert not bound <= 1e9


@pytest.mark.skipif(native() is None, reason="the native code is not built")
@given(seed=st.integers(0, 9999), degree=st.integers(0, 10), decades=st.integers(-9, 9))
def test_with_and_without_the_native_code_peaks_are_the_same(
    seed: int, degree: int, decades: int
) -> None:
    """Rows of all sizes, some of which have the same peak within the tolerance."""
    rng = np.random.default_rng(seed)
    forms = polynomials(seed, 8, degree, 1)[:, :, 0] * 10.0**decades
    forms[:, [0, -1]] -= 3 * 10.0**decades  # so that they peak between their ends
    forms[4:] = forms[:4, ::-1] + rng.normal(0.0, 1e-9, (4, degree + 1)) * 10.0**decades
    tolerance = 1e-7 * 10.0**decades
    (ours, row, at), (theirs, other, there) = (
        bernstein.peak(forms, tolerance, use_kernel=natively) for natively in (True, False)
    )
    assert abs(ours - theirs) <= tolerance
    for which, fraction in ((row, at), (other, there)):
        # The fraction is an end of the interval that contains the peak.
        assert value_at(forms[which], fraction) >= max(ours, theirs) - 100 * tolerance


def value_at(form: np.ndarray, fraction: float) -> float:
    """Return the value of a polynomial by de Casteljau's scheme."""
    while len(form) > 1:
        form = (1 - fraction) * form[:-1] + fraction * form[1:]
    return float(form[0])


@given(st.integers(0, 9999), st.integers(0, 5))
def test_square_norms_are_the_polynomials_of_the_norm(seed: int, degree: int) -> None:
    power = polynomials(seed, 2, degree, 3)
    squares = bernstein.square_norm(bernstein.from_power(power, np.ones(2)))
    left, right = bernstein.halves(squares[..., None])
    middle = (0.5 ** np.arange(degree + 1)) @ power
    assert left[:, -1, 0] == pytest.approx((middle**2).sum(axis=-1))
    assert right[:, 0, 0] == pytest.approx((middle**2).sum(axis=-1))
