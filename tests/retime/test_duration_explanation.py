"""Why a motion takes its time: checked where the answer is known, and by timing again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointType
from planning.errors import RetimingFailed
from planning.retime.blend import blend_corners
from planning.retime.duration_explanation import explain_duration
from planning.retime.retimer import RETIMERS, retime
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import num_cases

SEVEN = group_of(*[JointType.REVOLUTE] * 7)
RUCKIG = RetimeOptions(method="ruckig")
SMOOTHNESS = {"toppra": 1, "ruckig": 2}


def test_a_single_joint_speeds_up_cruises_and_brakes() -> None:
    """From rest to rest over d with v and a: d / v + v / a, cruising for d / v - v / a."""
    group = group_of(JointType.REVOLUTE)
    limits = limits_of(group, 1.0, 4.0, 100.0)
    spline = JointPath(group, np.array([[0.0], [2.0]])).spline
    options = RetimeOptions()
    trajectory, _ = retime(spline, limits, options)
    found = explain_duration(spline, trajectory, limits, options)
    assert [entry.limit for entry in found.intervals] == [
        "acceleration",
        "velocity",
        "acceleration",
    ]
    edges = [entry.begin for entry in found.intervals] + [found.intervals[-1].end]
    np.testing.assert_allclose(edges, [0.0, 0.25, 2.0, 2.25], atol=0.01)
    assert {entry.where for entry in found.intervals} == {"g::j0"}
    savings = {entry.limit: entry.seconds for entry in found.savings}
    assert savings["velocity"] == pytest.approx(2.25 - (2 / 1.2 + 1.2 / 4), abs=1e-3)
    assert savings["acceleration"] == pytest.approx(0.25 - 1 / 4.8, abs=1e-3)


@pytest.mark.parametrize("method", sorted(RETIMERS))
@settings(max_examples=num_cases(1, 80))
@given(seed=st.integers(0, 10_000))
def test_intervals_cover_the_motion_and_savings_are_those_of_retiming(
    method: str, seed: int
) -> None:
    limits = limits_of(SEVEN)
    path = JointPath(SEVEN, random_waypoints(SEVEN, seed, 4))
    spline = blend_corners(path, 0.05, SMOOTHNESS[method])
    options = RetimeOptions(method=method, velocity_scale=0.9, acceleration_scale=0.5)
    trajectory, report = retime(spline, limits, options)
    found = explain_duration(spline, trajectory, limits, options)
    begins = [entry.begin for entry in found.intervals]
    ends = [entry.end for entry in found.intervals]
    assert begins == [0.0, *ends[:-1]]
    assert ends[-1] == pytest.approx(report.duration)
    assert all(entry.limit and 0 < entry.share <= 1 for entry in found.intervals)
    assert max(entry.share for entry in found.intervals) > 0.97
    gains = [entry.seconds for entry in found.savings]
    assert gains == sorted(gains, reverse=True)
    assert all(0 < gain < report.duration for gain in gains)
    met = {*report.binding.items()}
    met |= {(entry.limit, entry.where) for entry in found.intervals if entry.share >= 0.97}
    assert {(saving.limit, saving.where) for saving in found.savings} <= met
    assert len(found.savings) <= 6


@settings(max_examples=num_cases(1))
@given(seed=st.integers(0, 10_000))
def test_shares_are_those_of_the_limit_that_is_named(seed: int) -> None:
    limits = limits_of(SEVEN)
    spline = blend_corners(JointPath(SEVEN, random_waypoints(SEVEN, seed, 4)), 0.05, 2)
    trajectory, _ = retime(spline, limits, RUCKIG)
    for entry in explain_duration(spline, trajectory, limits, RUCKIG).intervals:
        block = int(entry.where.removeprefix("g::j"))
        order = RETIMERS["ruckig"].rates.index(entry.limit) + 1
        # Jerk jumps: only an instant that was looked at has the share that was seen.
        times = np.linspace(0.0, trajectory.duration, 401)
        times = times[(times >= entry.begin) & (times <= entry.end)]
        rates = np.abs(trajectory.tangents(times, order)[:, block])
        used = float(rates.max() / getattr(limits, entry.limit)[block])
        assert entry.share == pytest.approx(min(1.0, used), abs=1e-6)


@pytest.mark.parametrize("method", sorted(RETIMERS))
def test_a_requested_duration_is_the_binding_limit(method: str) -> None:
    limits = limits_of(SEVEN)
    spline = blend_corners(
        JointPath(SEVEN, random_waypoints(SEVEN, 5, 3)), 0.05, SMOOTHNESS[method]
    )
    least = retime(spline, limits, RetimeOptions(method=method))[0].duration
    for factor, limited in ((1.0, True), (1.5, False)):
        options = RetimeOptions(method=method, duration=factor * least)
        trajectory, _ = retime(spline, limits, options)
        found = explain_duration(spline, trajectory, limits, options)
        assert ({entry.limit for entry in found.intervals} == {"duration"}) is not limited
        assert bool(found.savings) is limited


def test_while_nothing_moves_nothing_binds() -> None:
    limits = limits_of(SEVEN)
    spline = JointPath(SEVEN, np.zeros((2, 7))).spline
    trajectory, _ = retime(spline, limits, RUCKIG)
    found = explain_duration(spline, trajectory, limits, RUCKIG)
    assert [(entry.limit, entry.share) for entry in found.intervals] == [("", 0.0)]


@pytest.mark.parametrize("method", sorted(RETIMERS))
@settings(max_examples=num_cases(2, 120))
@given(seed=st.integers(0, 10_000), factor=st.floats(1.0, 20.0))
def test_a_requested_duration_is_met_exactly(method: str, seed: int, factor: float) -> None:
    limits = limits_of(SEVEN)
    path = JointPath(SEVEN, random_waypoints(SEVEN, seed, 3))
    spline = blend_corners(path, 0.05, SMOOTHNESS[method])
    least, free = retime(spline, limits, RetimeOptions(method=method))
    wanted = factor * least.duration
    slowed, report = retime(spline, limits, RetimeOptions(method=method, duration=wanted))
    assert slowed.duration == pytest.approx(wanted, rel=1e-12)
    assert report.duration == slowed.duration
    np.testing.assert_allclose(slowed.end, least.end, atol=1e-12)
    for order, rate in enumerate(free.utilisation, start=1):
        assert report.utilisation[rate] == pytest.approx(free.utilisation[rate] / factor**order)


def test_a_duration_below_the_least_is_refused_with_the_least() -> None:
    limits = limits_of(SEVEN)
    spline = JointPath(SEVEN, random_waypoints(SEVEN, 3, 2)).spline
    least = retime(spline, limits, RetimeOptions())[0].duration
    with pytest.raises(RetimingFailed) as caught:
        retime(spline, limits, RetimeOptions(duration=0.9 * least))
    assert caught.value.evidence["least"] == pytest.approx(least)
