"""Timing: on the path, within the limits, as quick as theory allows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import ProblemInvalid, RetimingFailed
from planning.retime.blend import blend_corners
from planning.retime.retimer import RETIMERS, retime
from tests.conftest import group_of, limits_of, random_waypoints
from tests.profiles import num_cases

GROUPS = {
    "seven joints": group_of(*[JointType.REVOLUTE] * 7),
    "plane": group_of(JointType.PLANAR),
    "space": group_of(JointType.FLOATING),
    "mixed": group_of(JointType.PRISMATIC, JointType.CONTINUOUS, JointType.PLANAR),
}
SMOOTHNESS = {"toppra": 1, "ruckig": 2}


def block_norms(group: JointGroup, rates: np.ndarray) -> np.ndarray:
    return np.stack([np.linalg.norm(rates[:, list(ix)], axis=1) for _, ix in group.blocks], axis=1)


@pytest.mark.parametrize("method", sorted(RETIMERS))
@pytest.mark.parametrize("name", GROUPS)
@given(seed=st.integers(0, 10_000), deviation=st.sampled_from([0.0, 0.01, 0.1]))
def test_limits_hold_ten_times_finer_than_delivered(
    name: str, method: str, seed: int, deviation: float
) -> None:
    group = GROUPS[name]
    limits = limits_of(group)
    path = JointPath(group, random_waypoints(group, seed, 4))
    spline = blend_corners(path, deviation, SMOOTHNESS[method])
    trajectory, report = retime(spline, limits, RetimeOptions(method=method))
    times = trajectory.sample_times(0.001)
    v, vdot = trajectory.velocities(times), trajectory.accelerations(times)
    assert (block_norms(group, v) <= limits.velocity).all()
    assert (block_norms(group, vdot) <= limits.acceleration).all()
    if method == "ruckig" and trajectory.manifold.is_flat:
        jerk = block_norms(group, trajectory.tangents(times, 3))
        assert (jerk <= limits.jerk).all()
    assert report.duration == trajectory.duration
    assert all(use <= 1 for use in report.utilisation.values())


@pytest.mark.parametrize("method", sorted(RETIMERS))
@pytest.mark.parametrize("name", GROUPS)
@given(seed=st.integers(0, 10_000), deviation=st.sampled_from([0.0, 0.05]))
def test_motion_stays_on_the_path_and_rests_at_its_ends(
    name: str, method: str, seed: int, deviation: float
) -> None:
    group = GROUPS[name]
    manifold = Manifold(group.joints)
    path = JointPath(group, random_waypoints(group, seed, 4, spread=0.4))
    spline = blend_corners(path, deviation, SMOOTHNESS[method])
    trajectory, _ = retime(spline, limits_of(group), RetimeOptions(method=method))
    assert np.abs(manifold.minus(trajectory.start, path.waypoints[0])).max() < 1e-9
    assert np.abs(manifold.minus(trajectory.end, path.waypoints[-1])).max() < 1e-9
    ends = trajectory.velocities(np.array([0.0, trajectory.duration]))
    assert np.abs(ends).max() < 1e-6
    dense = path.spline.positions(np.linspace(0, 1, 2000))
    step = path.length / 2000
    for q in trajectory.positions(np.linspace(0, trajectory.duration, num_cases(20, 40))):
        away = float(manifold.distance(dense, q[None]).min())
        assert away <= deviation + step + 1e-6


@pytest.mark.parametrize("method", sorted(RETIMERS))
@given(seed=st.integers(0, 10_000))
def test_position_and_velocity_are_continuous(method: str, seed: int) -> None:
    group = GROUPS["space"]
    path = JointPath(group, random_waypoints(group, seed, 4))
    spline = blend_corners(path, 0.05, SMOOTHNESS[method])
    trajectory, _ = retime(spline, limits_of(group), RetimeOptions(method=method))
    inner = trajectory.breaks[1:-1]
    h = 1e-9
    q = trajectory.manifold.distance(
        trajectory.positions(inner + h), trajectory.positions(inner - h)
    )
    v = trajectory.velocities(inner + h) - trajectory.velocities(inner - h)
    assert q.max(initial=0.0) < 1e-7
    assert np.abs(v).max(initial=0.0) < 1e-5


@given(st.floats(0.01, 8.0), st.floats(0.2, 3.0), st.floats(0.5, 20.0))
def test_a_line_takes_the_analytic_optimum(length: float, speed: float, push: float) -> None:
    group = group_of(JointType.REVOLUTE)
    path = JointPath(group, np.array([[0.0], [length]]))
    trajectory, _ = retime(path.spline, limits_of(group, speed, push), RetimeOptions())
    ramp = speed / push
    is_bang_bang = speed * ramp >= length
    best = 2 * np.sqrt(length / push) if is_bang_bang else length / speed + ramp
    assert trajectory.duration == pytest.approx(best, rel=1e-6)


@given(st.floats(0.05, 8.0), st.floats(5.0, 200.0))
def test_ruckig_takes_the_analytic_optimum_of_a_jerk_limited_line(
    length: float, jerk: float
) -> None:
    group = group_of(JointType.PRISMATIC)
    path = JointPath(group, np.array([[0.0], [length]]))
    limits = limits_of(group, 1e3, 1e4, jerk)
    trajectory, _ = retime(path.spline, limits, RetimeOptions(method="ruckig"))
    # Rest to rest by jerk alone: four equal phases, length = 2 j (T / 4)^3.
    assert trajectory.duration == pytest.approx(4 * (length / (2 * jerk)) ** (1 / 3), rel=1e-6)


def test_rounding_corners_saves_time_and_costs_no_more_than_allowed() -> None:
    group = GROUPS["seven joints"]
    path = JointPath(group, random_waypoints(group, 3, 6))
    durations = [
        retime(blend_corners(path, d), limits_of(group), RetimeOptions())[0].duration
        for d in (0.0, 0.02, 0.1)
    ]
    assert durations == sorted(durations, reverse=True)
    assert durations[-1] < 0.95 * durations[0]


def test_scales_slow_a_straight_motion_by_exactly_their_factor() -> None:
    group = group_of(JointType.REVOLUTE)
    path = JointPath(group, np.array([[0.0], [3.0]]))
    limits = limits_of(group, 1.0, 1e6)
    full = retime(path.spline, limits, RetimeOptions())[0].duration
    half = retime(path.spline, limits, RetimeOptions(velocity_scale=0.5))[0].duration
    assert half == pytest.approx(2 * full, rel=1e-3)


@pytest.mark.parametrize("scale", [0.0, -1.0, 1.01, float("nan")])
def test_scales_outside_their_range_are_refused(scale: float) -> None:
    group = group_of(JointType.REVOLUTE)
    path = JointPath(group, np.array([[0.0], [1.0]]))
    with pytest.raises(ProblemInvalid, match="velocity_scale"):
        retime(path.spline, limits_of(group), RetimeOptions(velocity_scale=scale))


@pytest.mark.parametrize("method", sorted(RETIMERS))
def test_waypoints_that_repeat_do_no_harm(method: str) -> None:
    group = GROUPS["seven joints"]
    waypoints = random_waypoints(group, 5, 4)
    repeated = np.repeat(waypoints, 2, axis=0)
    repeated[3] += 1e-13
    path = JointPath(group, repeated)
    spline = blend_corners(path, 0.05, SMOOTHNESS[method])
    trajectory, _ = retime(spline, limits_of(group), RetimeOptions(method=method))
    assert np.allclose(trajectory.end, waypoints[-1])


@pytest.mark.parametrize("gap", [1e-4, 1e-6, 1e-7, 1e-8, 3e-9])
def test_waypoints_that_nearly_repeat_cost_hardly_any_time(gap: float) -> None:
    group = GROUPS["seven joints"]
    waypoints = random_waypoints(group, 5, 5)
    pairs = np.repeat(waypoints, 2, axis=0)
    pairs[1::2] += gap * np.random.default_rng(5).normal(size=waypoints.shape)
    durations = [
        retime(blend_corners(JointPath(group, w), 0.1), limits_of(group), RetimeOptions())[
            0
        ].duration
        for w in (waypoints, pairs)
    ]
    # From 1e-6 on two corners so near each other have to be passed much more slowly than one.
    assert durations[1] == pytest.approx(durations[0], rel=1e-3 if gap < 1e-6 else 0.7)


@pytest.mark.parametrize("method", sorted(RETIMERS))
def test_a_path_that_goes_nowhere_is_a_moment_of_rest(method: str) -> None:
    group = GROUPS["space"]
    q = random_waypoints(group, 1, 1)[0]
    path = JointPath(group, np.stack([q, q]))
    trajectory, report = retime(path.spline, limits_of(group), RetimeOptions(method=method))
    assert 0 < trajectory.duration == report.duration <= 0.01
    assert np.allclose(trajectory.positions(trajectory.sample_times(0.01)), q)


def test_the_same_path_gives_the_same_bytes() -> None:
    group = GROUPS["mixed"]
    path = JointPath(group, random_waypoints(group, 8, 5))
    first, second = (
        retime(blend_corners(path, 0.05), limits_of(group), RetimeOptions())[0] for _ in range(2)
    )
    assert first == second


def test_stopping_is_reported() -> None:
    group = GROUPS["plane"]
    path = JointPath(group, random_waypoints(group, 2, 5))
    limits: JointLimits = limits_of(group)
    assert retime(path.spline, limits, RetimeOptions())[1].stops == 3
    assert retime(blend_corners(path, 0.05), limits, RetimeOptions())[1].stops == 0


@pytest.mark.parametrize("method", sorted(RETIMERS))
def test_a_path_that_needs_a_stuck_joint_is_refused_with_its_name(method: str) -> None:
    group = GROUPS["seven joints"]
    limits = limits_of(group)
    velocity = np.array(limits.velocity)
    velocity[2] = 0.0
    stuck = JointLimits(
        limits.lower,
        limits.upper,
        velocity,
        limits.acceleration,
        limits.jerk,
        limits.effort,
        limits.blocks,
    )
    path = JointPath(group, random_waypoints(group, 1, 3))
    with pytest.raises(RetimingFailed, match="g::j2") as caught:
        retime(path.spline, stuck, RetimeOptions(method=method))
    assert caught.value.evidence == {"method": method, "limit": "velocity", "stuck": ["g::j2"]}
    waypoints = random_waypoints(group, 1, 3)
    waypoints[:, 2] = 0.3
    still = retime(JointPath(group, waypoints).spline, stuck, RetimeOptions(method=method))[0]
    assert np.ptp(still.positions(still.sample_times(0.01))[:, 2]) == 0


@pytest.mark.parametrize("method", sorted(RETIMERS))
@given(seed=st.integers(0, 10_000), factor=st.floats(0.1, 10.0))
def test_time_scales_as_the_limits_do(method: str, seed: int, factor: float) -> None:
    group = GROUPS["mixed"]
    path = JointPath(group, random_waypoints(group, seed, 3))
    spline = blend_corners(path, 0.05, SMOOTHNESS[method])
    options = RetimeOptions(method=method)
    slow = limits_of(group, 2.0, 10.0, 100.0)
    fast = limits_of(group, 2.0 * factor, 10.0 * factor**2, 100.0 * factor**3)
    wanted = retime(spline, slow, options)[0].duration / factor
    # The speeds that ruckig's plan may choose from are a notch of a thousandth apart.
    assert retime(spline, fast, options)[0].duration == pytest.approx(wanted, rel=5e-3)
