"""toppra's speeds: near the optimum, on curves and in blocks of several coordinates."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointLimits, JointType
from planning.refine.curves.bspline_basis import make_bspline
from planning.refine.curves.power_basis import joint_spline
from planning.retime.blend import blend_corners
from planning.retime.cells import cut_at, even_edges
from planning.retime.retimer import retime
from tests.conftest import group_of, limits_of, random_waypoints
from tests.retime.splines import SEVEN, smooth_spline


def in_parts(spline: JointSpline, count: int) -> JointSpline:
    """Return the same curve in more pieces, each of which is cut into cells for itself."""
    return cut_at(spline, even_edges(spline.breaks, np.full(spline.num_pieces, count)))


@pytest.mark.parametrize("seed", range(4))
def test_curves_take_hardly_longer_than_plain_toppra_says(seed: int) -> None:
    spline, theirs = smooth_spline(seed)
    limits = limits_of(SEVEN)
    grid = np.linspace(0, 1, 1001)
    both = [
        JointVelocityConstraint(np.stack([-limits.velocity, limits.velocity], axis=1)),
        JointAccelerationConstraint(np.stack([-limits.acceleration, limits.acceleration], axis=1)),
    ]
    speeds = TOPPRA(both, theirs, gridpoints=grid, solver_wrapper="seidel")
    speeds = speeds.compute_parameterization(0, 0)[1]
    plain = float((2 * np.diff(grid) / (speeds[1:] + speeds[:-1])).sum())
    trajectory, report = retime(spline, limits, RetimeOptions())
    assert report.stops == 0
    assert 0.99 * plain < trajectory.duration < 1.02 * plain


@given(st.integers(0, 10_000))
def test_a_limit_is_met_as_well_as_kept(seed: int) -> None:
    group = group_of(JointType.FLOATING)
    path = JointPath(group, random_waypoints(group, seed, 4))
    _, report = retime(blend_corners(path, 0.05), limits_of(group), RetimeOptions())
    assert max(report.utilisation.values()) > 1 - 1e-5


def test_a_block_may_use_its_whole_disc_in_any_direction() -> None:
    group = group_of(JointType.PLANAR)
    limits = limits_of(group)
    durations = []
    for angle in np.linspace(0, np.pi / 2, 7):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        waypoints = np.zeros((3, 3))
        waypoints[:, :2] = np.array([[0.0, 0.0], [1.0, 0.0], [1.5, 0.8]]) @ turn.T
        spline = blend_corners(JointPath(group, waypoints), 0.05)
        durations.append(retime(spline, limits, RetimeOptions())[0].duration)
    assert np.ptp(durations) < 1e-3 * durations[0]


def test_a_joint_with_no_limit_does_not_matter() -> None:
    path = JointPath(SEVEN, random_waypoints(SEVEN, 2, 4))
    limits = limits_of(SEVEN)
    free = np.where(np.arange(7) == 3, np.inf, 1.0)
    unlimited = JointLimits(
        limits.lower,
        limits.upper,
        limits.velocity * free,
        limits.acceleration * free,
        limits.jerk,
        limits.effort,
        limits.blocks,
    )
    spline = blend_corners(path, 0.05)
    bound = retime(spline, limits, RetimeOptions())[0].duration
    assert retime(spline, unlimited, RetimeOptions())[0].duration <= bound * 1.001


@pytest.mark.parametrize("kind", [JointType.REVOLUTE, JointType.PLANAR, JointType.FLOATING])
@given(seed=st.integers(0, 10_000))
def test_the_speeds_nearly_keep_the_limits_before_the_audit(kind: JointType, seed: int) -> None:
    group = group_of(kind, kind)
    path = JointPath(group, random_waypoints(group, seed, 4))
    _, report = retime(blend_corners(path, 0.05), limits_of(group), RetimeOptions())
    assert report.slowed <= 1 + 1e-3


@pytest.mark.parametrize("kind", [JointType.REVOLUTE, JointType.PLANAR, JointType.FLOATING])
@given(seed=st.integers(0, 10_000))
def test_many_more_cells_would_save_little(kind: JointType, seed: int) -> None:
    group = group_of(kind, kind)
    spline = blend_corners(JointPath(group, random_waypoints(group, seed, 4)), 0.1)
    few, _ = retime(spline, limits_of(group), RetimeOptions())
    many, _ = retime(in_parts(spline, 10), limits_of(group), RetimeOptions())
    assert few.num_pieces * 2 < many.num_pieces
    assert few.duration < many.duration * 1.01


@given(seed=st.integers(0, 10_000))
def test_a_curve_without_lines_is_as_quick_as_on_many_more_cells(seed: int) -> None:
    steps = np.random.default_rng(seed).normal(0.2, 0.05, (10, 7))
    spline = joint_spline(SEVEN.joints, make_bspline(np.cumsum(steps, axis=0)))
    few, _ = retime(spline, limits_of(SEVEN), RetimeOptions())
    many, _ = retime(in_parts(spline, 8), limits_of(SEVEN), RetimeOptions())
    assert few.num_pieces * 2 < many.num_pieces
    assert few.duration < many.duration * 1.019


def test_lines_are_three_phases_and_corners_a_few() -> None:
    path = JointPath(SEVEN, random_waypoints(SEVEN, 2, 8))
    trajectory, report = retime(blend_corners(path, 0.1), limits_of(SEVEN), RetimeOptions())
    assert report.stops == 0
    assert trajectory.num_pieces <= 7 * 3 + 6 * 14
