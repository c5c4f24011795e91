"""Optimized profiles: faster than the given ones, within limits, and near the optimum."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointType
from planning.retime.blend import blend_corners
from planning.retime.compose import compose
from planning.retime.jerk.profile_optimizer import optimize_profile
from planning.retime.jerk.timing_spline import TimingSpline
from planning.retime.retimer import retime
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import num_cases
from tests.retime.splines import SEVEN, slow_profile, smooth_spline

SPACE = group_of(JointType.FLOATING)


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 10_000), jerk=st.sampled_from([20.0, 100.0, 1000.0]))
def test_limits_are_kept_at_every_sample_and_rest_at_both_ends(seed: int, jerk: float) -> None:
    stretch, _ = smooth_spline(seed)
    limits = limits_of(SEVEN, jerk=jerk)
    motion = compose(stretch, optimize_profile(stretch, slow_profile(stretch), limits))
    times = np.linspace(0.0, motion.duration, 3000)
    for order, bound in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
        uses = np.abs(motion.tangents(times, order)) / bound
        assert uses.max() <= 1 + 1e-6
    for order in (1, 2):
        ends = np.abs(motion.tangents(times[[0, -1]], order)).max()
        assert ends < 1e-6
    np.testing.assert_allclose(motion.end, stretch.end, atol=1e-9)


@settings(max_examples=num_cases(4))
@given(seed=st.integers(0, 10_000))
def test_generous_jerk_leaves_little_to_the_optimum(seed: int) -> None:
    stretch, _ = smooth_spline(seed)
    limits = limits_of(SEVEN, jerk=3e4)
    optimum = retime(stretch, limits, RetimeOptions())[0].duration
    bounded = retime(stretch, limits, RetimeOptions(method="ruckig"))[0].duration
    assert 0.995 * optimum < bounded < 1.12 * optimum


@settings(max_examples=num_cases(2))
@given(seed=st.integers(0, 10_000))
def test_where_it_begins_matters_little(seed: int) -> None:
    stretch, _ = smooth_spline(seed)
    limits = limits_of(SEVEN)
    wanted = retime(stretch, limits, RetimeOptions(method="ruckig"))[0].duration
    found = optimize_profile(stretch, slow_profile(stretch), limits)
    again = optimize_profile(stretch, found, limits)
    assert again.duration <= found.duration * (1 + 1e-9)
    assert wanted < 1.05 * again.duration


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_the_passage(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = rng.uniform(0.5, 1.5, 9)
    places = np.append(0.0, np.cumsum(rng.uniform(0.5, 1.5, 9)))
    derivatives = TimingSpline.through(h, places).derivatives()
    for k in range(9):
        moved = [
            TimingSpline.through(h * np.exp(step * (np.arange(9) == k)), places)
            for step in (-1e-6, 1e-6)
        ]
        for end in range(2):
            both = [np.stack([p.v[end : 9 + end], p.a[end : 9 + end], p.j]) for p in moved]
            measured = (both[1] - both[0]) / 2e-6
            np.testing.assert_allclose(derivatives[end, :, :, k], measured.T, atol=1e-7)


def test_a_profile_that_cannot_be_optimized_is_returned() -> None:
    spline = blend_corners(JointPath(SPACE, random_waypoints(SPACE, 2, 4)), 0.1, 2)
    profile = slow_profile(spline)
    assert optimize_profile(spline, profile, limits_of(SPACE)) is profile
