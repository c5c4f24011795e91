"""Joints that speed up and slow down differently: known times, and bounds that hold."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointType
from planning.retime.blend import blend_corners
from planning.retime.duration_explanation import explain_duration
from planning.retime.limits.signed_acceleration import SignedAcceleration
from planning.retime.retimer import RETIMERS, retime
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import num_cases

SMOOTHNESS = {"toppra": 1, "ruckig": 2}


@given(
    length=st.floats(0.05, 8.0),
    low=st.floats(0.5, 9.0),
    high=st.floats(0.5, 9.0),
    speed=st.floats(0.2, 3.0),
    sign=st.sampled_from([-1.0, 1.0]),
)
def test_one_joint_takes_the_time_of_its_two_ramps(
    length: float, low: float, high: float, speed: float, sign: float
) -> None:
    """Up by `up`, down by `down`: sqrt(2 d (1 / up + 1 / down)), or with a cruise in between."""
    group = group_of(JointType.PRISMATIC)
    path = JointPath(group, np.array([[0.0], [sign * length]]))
    limit = SignedAcceleration({"g::j0": (-low, high)}, (0,))
    motion, report = retime(path.spline, limits_of(group, speed), RetimeOptions(), [limit])
    up, down = (high, low) if sign > 0 else (low, high)
    ramps = 1 / up + 1 / down
    is_bang_bang = speed**2 * ramps / 2 >= length
    best = np.sqrt(2 * length * ramps) if is_bang_bang else length / speed + speed * ramps / 2
    assert motion.duration == pytest.approx(best, rel=1e-6)
    assert motion.num_pieces <= 3
    assert report.utilisation["acceleration_bounds"] == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("method", sorted(RETIMERS))
@given(seed=st.integers(0, 10_000), deviation=st.sampled_from([0.0, 0.05]))
@settings(max_examples=num_cases(6))
def test_bounds_hold_and_some_limit_is_met(method: str, seed: int, deviation: float) -> None:
    group = group_of(JointType.REVOLUTE, JointType.PRISMATIC, JointType.PLANAR)
    bounds = {"g::j0": (-5.0, 3.0), "g::j2.angular": (-1.0, 8.0)}
    limit = SignedAcceleration(bounds, (0, 4))
    path = JointPath(group, random_waypoints(group, seed, 4))
    spline = blend_corners(path, deviation, SMOOTHNESS[method])
    motion, report = retime(spline, limits_of(group), RetimeOptions(method=method), [limit])
    accelerations = motion.tangents(motion.sample_times(0.001), 2)[:, [0, 4]]
    for column, (low, high) in zip(accelerations.T, bounds.values(), strict=True):
        assert low <= column.min()
        assert column.max() <= high
    assert 1 - 1e-5 < max(report.utilisation.values()) <= 1
    if method == "toppra":
        assert report.slowed < 1 + 1e-3


def test_bounds_as_wide_as_the_limits_change_nothing() -> None:
    group = group_of(*[JointType.REVOLUTE] * 3)
    path = JointPath(group, random_waypoints(group, 4, 5))
    spline = blend_corners(path, 0.05)
    limit = SignedAcceleration({"g::j1": (-10.0, 10.0)}, (1,))
    plain, _ = retime(spline, limits_of(group), RetimeOptions())
    bound, _ = retime(spline, limits_of(group), RetimeOptions(), [limit])
    assert bound.duration == pytest.approx(plain.duration, rel=1e-6)


def test_the_explanation_has_the_saving_by_a_larger_bound() -> None:
    group = group_of(JointType.PRISMATIC)
    path = JointPath(group, np.array([[0.0], [0.5]]))
    limit = SignedAcceleration({"g::j0": (-2.0, 1.0)}, (0,))
    spline, limits, options = path.spline, limits_of(group, 9.0), RetimeOptions()
    motion, _ = retime(spline, limits, options, [limit])
    found = explain_duration(spline, motion, limits, options, [limit])
    assert {(entry.limit, entry.where) for entry in found.intervals} == {
        ("acceleration_bounds", "g::j0")
    }
    saved = motion.duration * (1 - 1 / np.sqrt(1.2))
    assert found.savings[0].seconds == pytest.approx(saved, rel=1e-3)
