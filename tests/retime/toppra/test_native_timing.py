"""The kernel's speeds, profiles, compositions and whole timings are toppra's and numpy's."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.request.deadline import NO_DEADLINE
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.errors import RetimingFailed
from planning.kernel.native import native
from planning.retime.blend import blend_corners
from planning.retime.compose import compose, compose_in_numpy
from planning.retime.limit_utilization import RATES, max_block_utilization, max_utilization
from planning.retime.limits.timed_piece import TimedPiece, audited
from planning.retime.line_profile import LineLimits, profile_between, profile_between_in_numpy
from planning.retime.profile import SpeedProfile
from planning.retime.smooth_pieces import smooth_pieces
from planning.retime.toppra.kernel_retimer import timed_by_kernel
from planning.retime.toppra.toppra_passes import speeds_by_toppra, squared_speeds
from planning.retime.toppra.toppra_retimer import toppra_profile
from tests.conftest import group_of, limits_of, random_waypoints
from tests.retime.splines import SEVEN, slow_profile, smooth_spline

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel was not built")
GROUPS = {count: group_of(*[JointType.REVOLUTE] * count) for count in (1, 2, 7, 9)}


def are_same(profile: SpeedProfile, other: SpeedProfile) -> bool:
    """Return whether all numbers are the same, bit by bit."""
    fields = [field.name for field in dataclasses.fields(SpeedProfile)]
    return all(np.array_equal(getattr(profile, f), getattr(other, f)) for f in fields)


def blended(count: int, seed: int, num_waypoints: int) -> list[JointSpline]:
    """Return the smooth pieces of a path with rounded corners."""
    path = JointPath(GROUPS[count], random_waypoints(GROUPS[count], seed, num_waypoints))
    return smooth_pieces(blend_corners(path, 0.1), 1)


def scaled_limits(group: JointGroup, seed: int) -> JointLimits:
    """Return limits that differ from joint to joint."""
    rng = np.random.default_rng(seed)
    limits = limits_of(group)
    scale = rng.uniform(0.1, 2.0, (2, len(limits.velocity)))
    return dataclasses.replace(
        limits,
        velocity=limits.velocity * scale[0],
        acceleration=limits.acceleration * scale[1],
    )


def step_by_step(spline: JointSpline, limits: JointLimits) -> list[TimedPiece]:
    """Return the smooth pieces of a path timed in numpy, with speeds by toppra itself."""
    return [
        audited(
            compose_in_numpy(piece, toppra_profile(piece, limits)),
            limits,
            RATES[:2],
            (),
            NO_DEADLINE,
        )
        for piece in smooth_pieces(spline, 1)
    ]


@given(
    count=st.sampled_from(sorted(GROUPS)),
    seed=st.integers(0, 10_000),
    num_waypoints=st.sampled_from([2, 3, 6, 40]),
    deviation=st.sampled_from([0.0, 0.1]),
)
def test_paths_are_timed_as_step_by_step(
    count: int, seed: int, num_waypoints: int, deviation: float
) -> None:
    group, limits = GROUPS[count], scaled_limits(GROUPS[count], seed)
    path = JointPath(group, random_waypoints(group, seed, num_waypoints))
    spline = blend_corners(path, deviation)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("planning.retime.toppra.toppra_retimer.squared_speeds", speeds_by_toppra)
        wanted = step_by_step(spline, limits)
    assert timed_by_kernel(spline, limits) == wanted


@given(
    count=st.sampled_from(sorted(GROUPS)),
    seed=st.integers(0, 10_000),
    num_waypoints=st.sampled_from([3, 6, 40]),
    deviation=st.sampled_from([0.008, 0.1]),
    smoothness=st.sampled_from([1, 2]),
)
def test_corners_are_rounded_as_in_numpy(
    count: int, seed: int, num_waypoints: int, deviation: float, smoothness: int
) -> None:
    group = GROUPS[count]
    path = JointPath(group, random_waypoints(group, seed, num_waypoints))
    found = blend_corners(path, deviation, smoothness)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("planning.retime.blend.native", lambda: None)
        assert blend_corners(path, deviation, smoothness) == found


@pytest.mark.parametrize("seed", range(4))
def test_paths_of_parabolas_alone_are_cut_as_finely(seed: int) -> None:
    limits = scaled_limits(SEVEN, seed)
    whole = next(piece for piece in blended(7, seed, 6) if piece.num_pieces > 2)
    is_curved = whole.coefficients[:, 2].any(axis=1)
    row = int(np.flatnonzero(is_curved)[0])
    curve = JointSpline(
        whole.joints,
        whole.breaks[row : row + 2] - whole.breaks[row],
        whole.bases[row : row + 1],
        whole.coefficients[row : row + 1],
    )
    assert timed_by_kernel(curve, limits) == step_by_step(curve, limits)


@given(seed=st.integers(0, 10_000), count=st.integers(1, 40), rows=st.integers(1, 8))
def test_speeds_are_toppras_bit_by_bit(seed: int, count: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    edges = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 0.2, count))])
    size = 2, count, rows
    half = rng.normal(size=size) * rng.choice([0.0, 1.0], size, p=[0.2, 0.8])
    a, b = (np.concatenate([part, -part], axis=1) for part in half)
    caps = rng.uniform(0.05, 5.0, count + 1)
    wanted = speeds_by_toppra(edges, (a, b), caps)
    module = native()
    assert module is not None
    assert np.array_equal(module.squared_speeds(edges, a, b, caps), wanted)


def test_rows_that_no_speed_keeps_are_left_to_toppra() -> None:
    edges, caps = np.array([0.0, 1.0, 2.0]), np.array([1.0, -1.0, 1.0])
    rows = np.ones((2, 2)), np.zeros((2, 2))
    module = native()
    assert module is not None
    assert not len(module.squared_speeds(edges, *rows, caps))
    with pytest.raises(RetimingFailed, match="no velocity profile"):
        squared_speeds(edges, rows, caps)


@given(seed=st.integers(0, 10_000), count=st.integers(1, 60))
def test_profiles_between_speeds_are_numpys(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    edges = np.concatenate([[0.0], np.cumsum(rng.uniform(1e-3, 1.0, count))])
    v = rng.choice([0.0, 0.3, 0.7, 1.0], count + 1)
    is_line = (rng.random(count) < 0.5) | (v[:-1] + v[1:] == 0)
    speed, up, down = rng.choice([1.0, 1.5], count), *rng.uniform(0.5, 20.0, (2, count))
    lines = LineLimits(is_line, speed, up, np.where(rng.random(count) < 0.5, up, down))
    assert are_same(
        profile_between(edges, v**2, lines), profile_between_in_numpy(edges, v**2, lines)
    )


@pytest.mark.parametrize("seed", range(4))
def test_compositions_with_jerk_are_numpys(seed: int) -> None:
    spline, _ = smooth_spline(seed)
    profile = slow_profile(spline)
    assert profile.j.any()
    assert compose(spline, profile) == compose_in_numpy(spline, profile)


@given(
    seed=st.integers(0, 10_000), terms=st.integers(1, 6), gain=st.sampled_from([1e-3, 1.0, 30.0])
)
def test_utilizations_are_those_of_numpys_search(seed: int, terms: int, gain: float) -> None:
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(size=(5, terms, 7)) * gain
    curve = TimedTrajectory(SEVEN.joints, np.linspace(0.0, 2.0, 6), np.zeros((5, 7)), coefficients)
    limits = scaled_limits(SEVEN, seed)
    for order in (1, 2):
        found, wanted = (
            of(curve, limits, order) for of in (max_utilization, max_block_utilization)
        )
        assert found.block == wanted.block
        assert found.fraction == pytest.approx(wanted.fraction, rel=1e-12)


def test_a_limit_that_is_infinite_or_zero_is_left_to_numpy() -> None:
    spline, _ = smooth_spline(0)
    trajectory = compose(spline, slow_profile(spline))
    limits = limits_of(SEVEN)
    free = dataclasses.replace(limits, velocity=np.append(limits.velocity[:-1], np.inf))
    assert 0 < max_utilization(trajectory, free, 1).fraction < 1
