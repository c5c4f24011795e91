"""Visits to a box by the kernel are those of numpy, and contain every sample in the box."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.kernel.native import native
from planning.retime.limits.zone_speed import visits_in_numpy

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel was not built")
HALF = np.array([0.3, 0.4, 0.5])


def random_path(seed: int, count: int, terms: int) -> tuple[np.ndarray, np.ndarray]:
    """Return breaks, and Bernstein coefficients of a path about a box."""
    rng = np.random.default_rng(seed)
    breaks = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, count))])
    return breaks, rng.normal(scale=0.5, size=(count, terms, 3))


@given(seed=st.integers(0, 10_000), count=st.integers(1, 12), terms=st.integers(1, 9))
def test_parts_are_numpys(seed: int, count: int, terms: int) -> None:
    breaks, points = random_path(seed, count, terms)
    module = native()
    assert module is not None
    pieces, low, high = module.box_visits(breaks, points, HALF, 14)
    wanted = visits_in_numpy(breaks, points, HALF)
    assert np.array_equal(pieces, wanted.pieces)
    assert np.array_equal(low, wanted.low)
    assert np.array_equal(high, wanted.high)


@given(seed=st.integers(0, 10_000))
def test_every_sample_in_the_box_is_in_a_part(seed: int) -> None:
    breaks, points = random_path(seed, 4, 2)
    module = native()
    assert module is not None
    _, low, high = module.box_visits(breaks, points, HALF, 14)
    for piece, (begin, end) in enumerate(pairwise(breaks)):
        share = np.linspace(0.0, 1.0, 101)[:, None]
        inside = (np.abs(points[piece, 0] * (1 - share) + points[piece, 1] * share) < HALF).all(
            axis=1
        )
        for time in begin + (end - begin) * share[inside, 0]:
            assert ((low <= time) & (time <= high)).any()
