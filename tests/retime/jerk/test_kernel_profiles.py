"""The native kernel times paths as Python does, or quicker."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointType
from planning.kernel.native import native
from planning.retime.blend import blend_corners
from planning.retime.block_peaks import block_peaks
from planning.retime.cells import cut_at, even_edges
from planning.retime.jerk.profile_optimizer import optimize_profile
from planning.retime.jerk.speed_dp import SpeedCells, solve_speed_dp
from planning.retime.profile import SpeedProfile
from planning.retime.smooth_pieces import smooth_pieces
from tests.conftest import group_of, limits_of, random_waypoints
from tests.retime.splines import SEVEN, slow_profile, smooth_spline

pytestmark = pytest.mark.skipif(native() is None, reason="there is no native kernel")


def path_of(seed: int) -> JointSpline:
    """Return a smooth curve, or rounded corners, whose third derivative jumps."""
    if seed % 2:
        return smooth_spline(seed)[0]
    path = JointPath(SEVEN, random_waypoints(SEVEN, seed, 5))
    return smooth_pieces(blend_corners(path, 0.1, 2), 2)[0]


@pytest.mark.parametrize("seed", range(4))
def test_optimized_profiles_are_those_of_python(seed: int) -> None:
    path, limits = path_of(seed), limits_of(SEVEN, jerk=[20.0, 100.0, 1000.0][seed % 3])
    slow = slow_profile(path)
    ours, reference = (optimize_profile(path, slow, limits, use_kernel=k) for k in (True, False))
    assert reference.duration < 0.5 * slow.duration
    for name in ("s", "v", "a", "j", "h"):
        wanted = getattr(reference, name)
        np.testing.assert_allclose(
            getattr(ours, name), wanted, rtol=0, atol=1e-6 * np.abs(wanted).max()
        )


def test_joints_beyond_eight_count_too() -> None:
    nine = group_of(*[JointType.REVOLUTE] * 9)
    path = JointPath(nine, random_waypoints(nine, 3, 4))
    piece = smooth_pieces(blend_corners(path, 0.1, 2), 2)[0]
    limits = limits_of(nine, jerk=100.0)
    slow = replace(limits, jerk=np.append(limits.jerk[:8], 5.0))
    for bounds in (limits, slow):
        ours, reference = (
            optimize_profile(piece, slow_profile(piece), bounds, use_kernel=k).duration
            for k in (True, False)
        )
        assert ours == pytest.approx(reference, rel=1e-6)


def test_a_profile_that_is_quicker_already_stays_but_for_its_scale() -> None:
    path, limits = path_of(1), limits_of(SEVEN)
    best = optimize_profile(path, slow_profile(path), limits)
    for _ in range(2):
        best = optimize_profile(path, best, limits)
    slowed = SpeedProfile(best.s, best.v / 2, best.a / 4, best.j / 8, best.h * 2)
    for given in (best, slowed):
        again = optimize_profile(path, given, limits)
        assert again.duration <= best.duration * (1 + 1e-9)


def cells_of(path: JointSpline, jerk: float) -> SpeedCells:
    limits = limits_of(SEVEN, jerk=jerk)
    cut = cut_at(path, even_edges(path.breaks, np.full(path.num_pieces, 5)))
    bounds = limits.velocity, limits.acceleration, limits.jerk
    peaks = [block_peaks(cut, limits, order) for order in (1, 2, 3)]
    m1, m2, m3 = (
        np.stack([peak / bound for bound in bounds[order:]]) for order, peak in enumerate(peaks)
    )
    return SpeedCells(cut.breaks, m1, m2, m3)


@pytest.mark.parametrize("seed", range(6))
def test_chains_of_segments_are_those_of_python(seed: int) -> None:
    cells = cells_of(path_of(seed), [20.0, 100.0, 1000.0][seed % 3])
    ours, reference = (solve_speed_dp(cells, use_kernel=k) for k in (True, False))
    for one, other in zip(ours, reference, strict=True):
        assert (one.begin, one.end, one.speeds) == (other.begin, other.end, other.speeds)
        np.testing.assert_allclose(one.bounds, other.bounds, rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_bounds_of_segments_keep_every_limit(seed: int) -> None:
    cells = cells_of(path_of(seed), 100.0)
    for segment in solve_speed_dp(cells):
        between = slice(segment.begin, segment.end)
        top, a, j = segment.bounds
        (v1, a1, j1), (a2, j2), (j3,) = (m[:, between] for m in (cells.m1, cells.m2, cells.m3))
        assert (v1 * top).max() <= 1 + 1e-9
        assert (a1 * a + a2 * top**2).max() <= 1 + 1e-9
        assert (j1 * j + 3 * j2 * top * a + j3 * top**3).max() <= 1 + 1e-9


def test_where_every_speed_breaks_a_limit_there_is_no_chain() -> None:
    module: Any = native()
    positions, shares = np.linspace(0.0, 1.0, 4), np.array([0.5])
    speeds = np.array([[0.0], [0.4], [0.4], [0.0]])
    for peak, num_segments in ((0.1, 3), (10.0, 0)):
        chain = module.fastest_chain(positions, np.full((6, 3, 1), peak), speeds, shares, 1)
        assert [len(part) for part in chain] == [num_segments] * 5
