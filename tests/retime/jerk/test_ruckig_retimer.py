"""Jerk-limited timing: jerk is kept everywhere, and costs little where it is generous."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup, JointType
from planning.retime.blend import blend_corners
from planning.retime.jerk import ruckig_retimer
from planning.retime.retimer import retime
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import num_cases
from tests.retime.splines import SEVEN, smooth_spline

SPACE = group_of(JointType.FLOATING)
RUCKIG = RetimeOptions(method="ruckig")


@pytest.mark.parametrize("group", [SEVEN, SPACE])
@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 10_000), deviation=st.sampled_from([0.0, 0.02, 0.2]))
def test_acceleration_is_continuous_and_its_slope_within_the_jerk(
    group: JointGroup, seed: int, deviation: float
) -> None:
    limits = limits_of(group)
    path = JointPath(group, random_waypoints(group, seed, 4))
    trajectory, _ = retime(blend_corners(path, deviation, 2), limits, RUCKIG)
    times = np.linspace(0, trajectory.duration, 3000)
    vdot = trajectory.accelerations(times)
    slopes = np.diff(vdot, axis=0) / np.diff(times)[:, None]
    for (_, indices), jerk in zip(group.blocks, limits.jerk, strict=True):
        # A mean of the jerk over an interval exceeds the jerk no more than rounding does.
        assert np.linalg.norm(slopes[:, list(indices)], axis=1).max() <= jerk * (1 + 1e-6)
    assert np.abs(vdot[[0, -1]]).max() < 1e-6


@settings(max_examples=num_cases(4))
@given(seed=st.integers(0, 10_000))
def test_generous_jerk_costs_little_more_than_none(seed: int) -> None:
    limits = limits_of(SEVEN, jerk=1e5)
    path = JointPath(SEVEN, random_waypoints(SEVEN, seed, 4))
    spline = blend_corners(path, 0.1, 2)
    unbounded = retime(spline, limits, RetimeOptions())[0].duration
    bounded = retime(spline, limits, RUCKIG)[0].duration
    assert 0.995 * unbounded < bounded < 1.25 * unbounded


def test_rounding_corners_pays_under_jerk_limits_too() -> None:
    limits = limits_of(SEVEN)
    rounded, resting = (
        sum(
            retime(
                blend_corners(JointPath(SEVEN, random_waypoints(SEVEN, seed, 5)), deviation, 2),
                limits,
                RUCKIG,
            )[0].duration
            for seed in range(5)
        )
        for deviation in (0.1, 0.0)
    )
    assert rounded < 0.95 * resting


def test_tighter_jerk_is_slower() -> None:
    path = JointPath(SEVEN, random_waypoints(SEVEN, 4, 4))
    spline = blend_corners(path, 0.1, 2)
    durations = [
        retime(spline, limits_of(SEVEN, jerk=jerk), RUCKIG)[0].duration
        for jerk in (1e4, 1e3, 1e2, 1e1)
    ]
    assert durations == sorted(durations)
    assert durations[-1] > 1.5 * durations[0]


@pytest.mark.parametrize("scale", [1e-6, 1e-2, 1e3])
def test_sizes_far_from_one_do_no_harm(scale: float) -> None:
    waypoints = random_waypoints(SEVEN, 6, 4) * scale
    spline = blend_corners(JointPath(SEVEN, waypoints), 0.1 * scale, 2)
    limits = limits_of(SEVEN, 2 * scale, 10 * scale, 100 * scale)
    unscaled = blend_corners(JointPath(SEVEN, waypoints / scale), 0.1, 2)
    wanted = retime(unscaled, limits_of(SEVEN), RUCKIG)[0].duration
    assert retime(spline, limits, RUCKIG)[0].duration == pytest.approx(wanted, rel=1e-2)


@pytest.mark.parametrize("group", [SEVEN, SPACE])
@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 10_000))
def test_the_plan_keeps_the_limits_before_the_audit(group: JointGroup, seed: int) -> None:
    path = JointPath(group, random_waypoints(group, seed, 4))
    _, report = retime(blend_corners(path, 0.05, 2), limits_of(group), RUCKIG)
    assert report.slowed <= 1 + 1e-6


def test_a_line_is_one_state_to_state_motion() -> None:
    # Seven phases of constant jerk at most; a line in several hops would have more.
    for seed in range(5):
        path = JointPath(SEVEN, random_waypoints(SEVEN, seed, 4, spread=1.5))
        trajectory, _ = retime(blend_corners(path, 0.0, 2), limits_of(SEVEN), RUCKIG)
        on_first_line = (trajectory.bases == path.waypoints[0]).all(axis=1)
        assert 3 <= on_first_line.sum() <= 7


@settings(max_examples=num_cases(3))
@given(seed=st.integers(0, 10_000), jerk=st.sampled_from([20.0, 100.0, 1000.0]))
def test_the_plan_keeps_the_limits_along_curves_too(seed: int, jerk: float) -> None:
    spline, _ = smooth_spline(seed)
    _, report = retime(spline, limits_of(SEVEN, jerk=jerk), RUCKIG)
    assert report.stops == 0
    assert report.slowed <= 1 + 1e-6


@pytest.mark.parametrize("seed", range(3))
def test_where_nothing_is_optimized_the_profile_is_that_of_fine_cells(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, limits = smooth_spline(seed)[0], limits_of(SEVEN)
    monkeypatch.setattr(ruckig_retimer, "optimize_profile", lambda _, profile, *__: profile)
    found = ruckig_retimer.ruckig_profile(path, limits).duration
    monkeypatch.setattr(ruckig_retimer, "can_optimize", lambda *_: False)
    assert found == ruckig_retimer.ruckig_profile(path, limits).duration


@pytest.mark.parametrize("seed", range(3))
def test_a_coarse_beginning_costs_little(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    path, limits = smooth_spline(seed)[0], limits_of(SEVEN)
    found = ruckig_retimer.ruckig_profile(path, limits).duration
    monkeypatch.setattr(ruckig_retimer, "can_optimize", lambda *_: False)
    assert found < 1.02 * ruckig_retimer.ruckig_profile(path, limits).duration
