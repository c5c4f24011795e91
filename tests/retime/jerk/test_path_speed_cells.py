"""The kernel's cells for the dynamic program are numpy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.kernel.native import native
from planning.retime.blend import blend_corners
from planning.retime.jerk.path_speed_cells import cells_in_numpy, speed_cells_of
from planning.retime.smooth_pieces import smooth_pieces
from tests.conftest import limits_of, random_waypoints
from tests.retime.splines import SEVEN, smooth_spline

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel was not built")


@given(
    seed=st.integers(0, 10_000),
    num_waypoints=st.integers(2, 9),
    deviation=st.sampled_from([0.0, 0.1]),
    num_cells=st.sampled_from([16, 40]),
)
def test_cells_are_numpys(seed: int, num_waypoints: int, deviation: float, num_cells: int) -> None:
    path = JointPath(SEVEN, random_waypoints(SEVEN, seed, num_waypoints))
    limits = limits_of(SEVEN, 2.0, 10.0, 100.0)
    pieces = smooth_pieces(blend_corners(path, deviation, 2), 2)
    for piece in [*pieces, smooth_spline(seed)[0]]:
        found, is_straight = speed_cells_of(piece, limits, num_cells)
        wanted, should_be_straight = cells_in_numpy(piece, limits, num_cells)
        assert np.array_equal(found.edges, wanted.edges)
        assert np.array_equal(is_straight, should_be_straight)
        for name in ("m1", "m2", "m3"):
            one, other = getattr(found, name), getattr(wanted, name)
            assert np.allclose(one, other, rtol=1e-11, atol=1e-9 * np.abs(other).max())
