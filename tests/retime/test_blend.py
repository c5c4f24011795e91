"""Rounded corners: near the path, of the requested smoothness, straight elsewhere."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.retime.blend import blend_corners
from planning.retime.smooth_pieces import path_derivatives, smooth_pieces
from tests.conftest import group_of, random_waypoints

GROUPS = {
    "joints": group_of(*[JointType.REVOLUTE] * 4),
    "plane": group_of(JointType.PLANAR),
    "space": group_of(JointType.FLOATING),
}


def sharpest_turn(path: JointPath) -> float:
    """Return the largest angle between one line and the next [rad]."""
    manifold = Manifold(path.group.joints)
    onward = manifold.minus(path.waypoints[2:], path.waypoints[1:-1])
    arriving = -manifold.minus(path.waypoints[:-2], path.waypoints[1:-1])
    lengths = np.linalg.norm(onward, axis=1) * np.linalg.norm(arriving, axis=1)
    return float(np.arccos(((onward * arriving).sum(axis=1) / lengths).clip(-1, 1)).max())


@pytest.mark.parametrize("smoothness", [1, 2])
@pytest.mark.parametrize("name", GROUPS)
@given(seed=st.integers(0, 10_000), deviation=st.floats(1e-4, 0.5))
def test_corners_are_passed_no_farther_than_allowed(
    name: str, smoothness: int, seed: int, deviation: float
) -> None:
    group = GROUPS[name]
    path = JointPath(group, random_waypoints(group, seed, 4, spread=0.5))
    curve = blend_corners(path, deviation, smoothness)
    dense = curve.positions(np.linspace(0, 1, 4000))
    manifold = Manifold(group.joints)
    for corner in path.waypoints:
        nearest = float(manifold.distance(dense, corner[None]).min())
        assert nearest <= deviation + path.length / 4000
    assert float(manifold.distance(curve.start, path.waypoints[0])) < 1e-12
    assert float(manifold.distance(curve.end, path.waypoints[-1])) < 1e-9


@pytest.mark.parametrize("smoothness", [1, 2])
@pytest.mark.parametrize("name", GROUPS)
@given(seed=st.integers(0, 10_000))
def test_derivatives_meet_at_every_break(name: str, smoothness: int, seed: int) -> None:
    group = GROUPS[name]
    path = JointPath(group, random_waypoints(group, seed, 5))
    assume(sharpest_turn(path) < 2.5)
    curve = blend_corners(path, 0.05, smoothness)
    pieces = np.arange(curve.num_pieces)
    ends = path_derivatives(curve, pieces, np.diff(curve.breaks))
    begins = path_derivatives(curve, pieces, np.zeros(len(pieces)))
    for order in range(smoothness):
        scale = max(1.0, float(np.abs(ends[order]).max()))
        assert np.abs(ends[order][:-1] - begins[order][1:]).max() < 1e-9 * scale
    assert len(smooth_pieces(curve, smoothness)) == 1


def test_speed_in_the_parameter_is_the_same_on_all_lines() -> None:
    group = GROUPS["joints"]
    curve = blend_corners(JointPath(group, random_waypoints(group, 1, 5)), 0.02)
    is_line = ~curve.coefficients[:, 2:].any(axis=(1, 2))
    speeds = np.linalg.norm(curve.coefficients[is_line, 1], axis=1)
    assert is_line.sum() == 4
    assert np.ptp(speeds) < 1e-9 * speeds[0]


def test_no_deviation_leaves_the_path_as_it_is() -> None:
    path = JointPath(GROUPS["space"], random_waypoints(GROUPS["space"], 1, 4))
    assert blend_corners(path, 0.0) == path.spline


def test_a_path_that_turns_back_on_itself_keeps_its_corner() -> None:
    group = GROUPS["joints"]
    waypoints = np.zeros((3, 4))
    waypoints[1, 0] = 1.0
    curve = blend_corners(JointPath(group, waypoints), 0.1)
    assert np.isclose(curve.positions(np.linspace(0, 1, 101))[:, 0].max(), 1.0)
    assert len(smooth_pieces(curve, 1)) == 2


@given(st.integers(0, 1000))
def test_a_straight_path_in_many_steps_is_one_stretch(seed: int) -> None:
    group = GROUPS["space"]
    ends = random_waypoints(group, seed, 2)
    fractions = np.sort(np.random.default_rng(seed).uniform(0, 1, 20))
    steps = Manifold(group.joints).interpolate(ends[0], ends[1], fractions)
    path = JointPath(group, np.concatenate([ends[:1], steps, ends[1:]]))
    assert len(smooth_pieces(blend_corners(path, 0.05), 1)) == 1
