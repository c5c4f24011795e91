"""Smoothed paths: as near as is said, smooth, and no slower for being sampled finely."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointType
from planning.retime.blend import blend_corners
from planning.retime.bspline_smoothing import smooth_path
from planning.retime.retimer import retime
from planning.retime.smooth_pieces import smooth_pieces
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import num_cases

FOUR = group_of(*[JointType.REVOLUTE] * 4)
RUCKIG = RetimeOptions(method="ruckig")
DEVIATIONS = (0.1, 0.03, 0.008)


def sampled(seed: int, count: int, jitter: float = 0.0) -> JointPath:
    """Return waypoints on a random smooth curve, unevenly spaced."""
    rng = np.random.default_rng(seed)
    amplitudes, phases = rng.normal(0.0, 0.4, (3, 4)), rng.uniform(0.0, 2 * np.pi, (3, 4))
    x = np.linspace(0.0, 1.0, count)
    x = (x + 0.02 * np.sin(6 * x * np.pi))[:, None]
    waves = [amplitudes[k] * np.sin((k + 1) * 2.0 * x + phases[k]) for k in range(3)]
    return JointPath(FOUR, sum(waves) + rng.normal(0.0, jitter, (count, 4)))


def from_polyline(points: np.ndarray, path: JointPath) -> np.ndarray:
    """Return distances of points from a path, shape (m,)."""
    begins, steps = path.waypoints[:-1], np.diff(path.waypoints, axis=0)
    offsets = points[:, None] - begins
    along = ((offsets * steps).sum(axis=2) / (steps**2).sum(axis=1)).clip(0, 1)
    return np.linalg.norm(offsets - along[..., None] * steps, axis=2).min(axis=1)


@settings(max_examples=num_cases(6))
@given(
    seed=st.integers(0, 10_000),
    count=st.sampled_from([4, 7, 30, 150]),
    jitter=st.sampled_from([0.0, 1e-3]),
)
def test_curves_are_smooth_and_as_near_as_they_say(seed: int, count: int, jitter: float) -> None:
    path = sampled(seed, count, jitter)
    found = smooth_path(path, DEVIATIONS)
    bounds = [away for away, _ in found]
    assert bounds == sorted(bounds, reverse=True)
    assert all(bound <= DEVIATIONS[0] for bound in bounds)
    for away, curve in found:
        dense = curve.positions(np.linspace(0.0, 1.0, 2000))
        assert from_polyline(dense, path).max() <= away
        assert len(smooth_pieces(curve, 2)) == 1
        np.testing.assert_allclose(curve.start, path.waypoints[0], atol=1e-12)
        np.testing.assert_allclose(curve.end, path.waypoints[-1], atol=1e-12)


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 10_000))
def test_the_bound_is_not_far_from_the_distance(seed: int) -> None:
    path = sampled(seed, 12)
    for away, curve in smooth_path(path, DEVIATIONS):
        true = from_polyline(curve.positions(np.linspace(0.0, 1.0, 3000)), path).max()
        assert away < 3 * true + 1e-4


@settings(max_examples=num_cases(1))
@given(seed=st.integers(0, 10_000))
def test_finer_samples_of_a_curve_make_no_slower_motion(seed: int) -> None:
    limits = limits_of(FOUR)
    durations = [
        min(
            retime(curve, limits, RUCKIG)[0].duration
            for _, curve in smooth_path(sampled(seed, count), DEVIATIONS[:2])
        )
        for count in (25, 50, 200)
    ]
    coarse, fine, finest = durations
    assert fine < 1.03 * coarse
    assert finest < 1.03 * fine
    rounded = retime(blend_corners(sampled(seed, 50), 0.1, 2), limits, RUCKIG)[0].duration
    assert fine < 0.8 * rounded


def test_lines_that_were_cut_are_lines_here_too() -> None:
    path = sampled(3, 6)
    middles = (path.waypoints[1:] + path.waypoints[:-1]) / 2
    order = np.argsort([*range(0, 12, 2), *range(1, 11, 2)], kind="stable")
    finer = JointPath(FOUR, np.concatenate([path.waypoints, middles])[order])
    for (a, one), (b, other) in zip(
        smooth_path(path, DEVIATIONS), smooth_path(finer, DEVIATIONS), strict=True
    ):
        assert a == pytest.approx(b, abs=1e-9)
        np.testing.assert_allclose(one.coefficients, other.coefficients, atol=1e-6)


@pytest.mark.parametrize("kind", [JointType.FLOATING])
def test_bodies_that_float_have_none(kind: JointType) -> None:
    group = group_of(kind)
    assert (
        smooth_path(JointPath(group, random_waypoints(group, 1, 9, spread=0.05)), DEVIATIONS) == []
    )


def test_a_zigzag_has_none() -> None:
    rows = np.zeros((9, 4))
    rows[1::2, 0] = 1.0
    rows[:, 1] = np.arange(9)
    assert smooth_path(JointPath(FOUR, rows), DEVIATIONS) == []
