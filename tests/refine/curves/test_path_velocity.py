"""The path velocity is the greatest within bounds: by hand on lines, by the retimer on curves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import Joint, JointGroup, JointLimits, JointType
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.constraints.request_bounds import signed_accelerations
from planning.refine.curves.bspline_basis import greville_abscissae, make_bspline
from planning.refine.curves.duration_bound import duration_lower_bound, rest_to_rest_durations
from planning.refine.curves.path_velocity import (
    NormalizedDerivatives,
    duration_gradient,
    duration_of,
    minimum_time_path_velocity,
    path_grid,
)
from planning.refine.curves.power_basis import joint_spline
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import retime
from tests.conftest import bundled_world
from tests.profiles import num_cases

SEEDS = st.integers(0, 2**32 - 1)


def limits_of(rng: np.random.Generator, size: int) -> JointLimits:
    wide = np.full(size, 10.0)
    return JointLimits(
        -wide,
        wide,
        rng.uniform(1, 3, size),
        rng.uniform(5, 20, size),
        rng.uniform(50, 500, size),
        wide,
        tuple((i,) for i in range(size)),
    )


def curve_of(rng: np.random.Generator, count: int, size: int) -> np.ndarray:
    steps = rng.normal(size=(count, size)) + 2 * rng.normal(size=size)
    return np.cumsum(0.1 * steps, axis=0)


def duration(points: np.ndarray, bounds: RateBounds) -> float:
    grid = path_grid(len(points))
    return duration_of(
        grid, minimum_time_path_velocity(grid, NormalizedDerivatives.of(grid, points, bounds))
    )


@settings(max_examples=num_cases(6))
@given(seed=SEEDS, count=st.integers(8, 17))
def test_it_is_what_the_retimer_finds(seed, count):
    rng = np.random.default_rng(seed)
    limits, points = limits_of(rng, 3), curve_of(rng, count, 3)
    joints = tuple(Joint(f"g::j{i}", JointType.REVOLUTE) for i in range(3))
    timed, _ = retime(joint_spline(joints, make_bspline(points)), limits, RetimeOptions())
    found = duration(points, RateBounds.of(limits, limits_jerk=False))
    assert 0.98 * timed.duration <= found <= 1.16 * timed.duration


@settings(max_examples=num_cases(6))
@given(seed=SEEDS, jerk=st.booleans())
def test_the_bounds_are_kept_and_met(seed, jerk):
    rng = np.random.default_rng(seed)
    bounds = RateBounds.of(limits_of(rng, 3), limits_jerk=jerk)
    points, grid = curve_of(rng, 12, 3), path_grid(12)
    rates = NormalizedDerivatives.of(grid, points, bounds)
    path_velocity = minimum_time_path_velocity(grid, rates)
    accelerations = np.abs(rates.accelerations(grid, path_velocity)).max(axis=(1, 2))
    used = path_velocity[1:-1] / rates.path_velocity_bounds()
    assert accelerations.max() <= 1 + 1e-9
    assert used.max() <= 1 + 1e-9
    # Bang-bang: at every grid point one of them binds, but for the solver's tolerance.
    nearby = np.maximum(accelerations[1:], accelerations[:-1])
    assert np.maximum(used, nearby).min() > 0.98


@given(seed=SEEDS)
def test_no_curve_beats_the_lower_bound_and_a_line_of_one_joint_meets_it(seed):
    rng = np.random.default_rng(seed)
    limits = limits_of(rng, 1)
    points = greville_abscissae(14)[:, None] * rng.uniform(0.05, 3.0)
    least = duration_lower_bound(limits, points[-1] - points[0], limits_jerk=False)
    assert duration(points, RateBounds.of(limits, limits_jerk=False)) == pytest.approx(
        least, rel=0.02
    )


@settings(max_examples=num_cases(6))
@given(seed=SEEDS)
def test_no_curve_beats_the_lower_bound(seed):
    rng = np.random.default_rng(seed)
    limits, points = limits_of(rng, 3), curve_of(rng, 12, 3)
    least = duration_lower_bound(limits, points[-1] - points[0], limits_jerk=False)
    # The grid bounds accelerations at its points only, which gains it a little.
    assert duration(points, RateBounds.of(limits, limits_jerk=False)) > 0.98 * least


@pytest.mark.parametrize(("moved", "seconds"), [(0.5, 2 * np.sqrt(0.5)), (3.0, 3.0 + 1.0)])
def test_the_lower_bound_by_hand(moved, seconds):
    ones = np.ones(2)
    limits = JointLimits(-ones, ones, ones, ones, ones, ones, ((0,), (1,)))
    least = duration_lower_bound(limits, np.array([0.1, -moved]), limits_jerk=False)
    assert least == pytest.approx(seconds)


def test_coordinates_that_are_limited_together_share_the_bound():
    one = np.ones(1)
    limits = JointLimits(-np.ones(2), np.ones(2), one, one, one, one, ((0, 1),))
    moved = np.array([3.0, 4.0])
    assert duration_lower_bound(limits, moved, limits_jerk=False) == pytest.approx(5.0 + 1.0)


@given(seed=SEEDS)
def test_the_duration_gradient_is_the_slope_of_the_duration(seed):
    grid = path_grid(9)
    b = np.append(0.0, np.append(np.random.default_rng(seed).uniform(1, 2, 23), 0.0))
    i, h = 7, 1e-6
    more = b.copy()
    more[i] *= 1 + h
    slope = (duration_of(grid, more) - duration_of(grid, b)) / h
    assert -duration_gradient(grid, b)[i] == pytest.approx(slope, rel=1e-4)


def signed_of(rng: np.random.Generator, size: int) -> np.ndarray:
    return np.stack([-rng.uniform(1, 30, size), rng.uniform(1, 30, size)])


@settings(max_examples=num_cases(6))
@given(seed=SEEDS, jerk=st.booleans())
def test_bounds_of_either_sign_are_kept_and_met(seed, jerk):
    rng = np.random.default_rng(seed)
    limits = limits_of(rng, 3)
    signed = signed_of(rng, 3)
    bounds = RateBounds.of(limits, limits_jerk=jerk, acceleration_bounds=signed)
    lowest, highest = bounds.acceleration_range * bounds.acceleration
    assert (lowest >= np.maximum(signed[0], -limits.acceleration) * (1 + 1e-12)).all()
    assert (highest <= np.minimum(signed[1], limits.acceleration) * (1 + 1e-12)).all()
    points, grid = curve_of(rng, 12, 3), path_grid(12)
    rates = NormalizedDerivatives.of(grid, points, bounds)
    path_velocity = minimum_time_path_velocity(grid, rates)
    accelerations = rates.accelerations(grid, path_velocity) * bounds.acceleration
    shares = np.maximum(accelerations / lowest, accelerations / highest).max(axis=(1, 2))
    assert shares.max() <= 1 + 1e-9
    nearby = np.maximum(shares[1:], shares[:-1])
    assert np.maximum(path_velocity[1:-1] / rates.path_velocity_bounds(), nearby).min() > 0.98


@settings(max_examples=num_cases(6))
@given(seed=SEEDS)
def test_speeding_up_and_slowing_down_differ_by_hand(seed):
    rng = np.random.default_rng(seed)
    limits, length = limits_of(rng, 1), rng.uniform(0.05, 3.0)
    signed = signed_of(rng, 1)
    down, up = np.minimum(np.abs(signed[:, 0]), limits.acceleration)
    top = min(limits.velocity[0], np.sqrt(2 * length * up * down / (up + down)))
    expected = length / top + top / 2 * (1 / up + 1 / down)
    for moved in (length, -length):
        least = duration_lower_bound(
            limits, np.array([moved]), limits_jerk=False, acceleration_bounds=signed
        )
        assert least == pytest.approx(expected)
    bounds = RateBounds.of(limits, limits_jerk=False, acceleration_bounds=signed)
    assert duration(greville_abscissae(14)[:, None] * length, bounds) == pytest.approx(
        expected, rel=0.02
    )


@settings(max_examples=num_cases(6))
@given(seed=SEEDS)
def test_under_signed_bounds_too_it_is_what_the_retimer_finds(seed):
    rng = np.random.default_rng(seed)
    limits, points = limits_of(rng, 3), curve_of(rng, 12, 3)
    world = bundled_world("ur5e_pickup")  # Bounds of joints do not use it.
    joints = tuple(Joint(f"g::j{i}", JointType.REVOLUTE) for i in range(3))
    group = JointGroup("g", joints, ())
    by_joint = {"g::j0": (-2.0, 9.0), "g::j2": (-8.0, 1.5)}
    options = RetimeOptions(acceleration_bounds=by_joint)
    spline = joint_spline(joints, make_bspline(points))
    timed, _ = retime(spline, limits, options, path_limits(world, group, options))
    signed = signed_accelerations(group, by_joint)
    found = duration(points, RateBounds.of(limits, limits_jerk=False, acceleration_bounds=signed))
    assert 0.98 * timed.duration <= found <= 1.16 * timed.duration
    moved = points[-1] - points[0]
    assert (
        duration_lower_bound(limits, moved, limits_jerk=False, acceleration_bounds=signed)
        < 1.02 * timed.duration
    )


@pytest.mark.parametrize(
    ("speed", "acceleration", "seconds"),
    [(2.0, np.inf, 1.5), (np.inf, 3.0, 2.0), (1.0, 1.0, 4.0), (1.0, 0.1, 2 * np.sqrt(30.0))],
)
def test_the_least_time_of_a_line_by_hand(speed, acceleration, seconds):
    assert rest_to_rest_durations(np.array([3.0]), speed, acceleration)[0] == pytest.approx(seconds)
    assert rest_to_rest_durations(np.zeros(1), speed, acceleration)[0] == 0.0
