"""ArcSegments: where they lead, by the manifold of cars, and how that changes, by differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointType
from planning.domain.robot.steering import Steering, manifold_of, steered
from planning.refine.cars.arc_segments import (
    ArcSegments,
    PathSamples,
    end_pose,
    knot_poses,
    sample_poses,
)
from planning.refine.cars.drive_problem import DriveProblem
from planning.refine.cars.end_constraint import projected_to_goal
from tests.profiles import num_cases
from tests.search.conftest import group_of

RADIUS = 0.3


def random_segments(rng: np.random.Generator, count: int, num_others: int = 1) -> ArcSegments:
    """Some of them straight, some of them short."""
    ways = rng.uniform(0.05, 0.6, count) * rng.choice([-1, 1], count)
    bends = rng.uniform(-1, 1, count) / RADIUS * rng.choice([0, 1, 1], count)
    return ArcSegments(ways, bends, rng.uniform(-1, 1, (count + 1, num_others)))


def car_with(num_arms: int, *, reverse: bool = True):
    group = group_of(JointType.PLANAR, *[JointType.REVOLUTE] * num_arms)
    return steered(group, {"r::j0": Steering(RADIUS, reverse)})


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_letters_lead_where_the_manifold_says(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    letters, start = random_segments(rng, count), rng.uniform(-1, 1, 3)
    manifold = manifold_of(car_with(0))
    q, expected = start, [start]
    for way, turn in zip(letters.signed_lengths, letters.turning_angles, strict=True):
        q = manifold.plus(q, np.array([way, 0.0, turn]))
        expected.append(q)
    spots, yaws = knot_poses(start, letters)
    found = np.stack([spots.real, spots.imag, yaws], axis=1)
    assert found == pytest.approx(np.array(expected), abs=1e-12)
    assert end_pose(start, letters).poses[0] == pytest.approx(expected[-1], abs=1e-12)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6), st.integers(1, 5))
def test_slopes_are_derivatives(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    letters, start = random_segments(rng, count, 0), rng.uniform(-1, 1, 3)
    spots = PathSamples(rng.integers(0, count, 6), rng.uniform(0, 1, 6))
    seen, end = sample_poses(start, letters, spots), end_pose(start, letters)
    h = 1e-6
    for k in range(2 * count):
        step = h * np.eye(2 * count)[k]
        sides = [letters.with_variables(letters.variables + way * step) for way in (1, -1)]
        poses = [sample_poses(start, side, spots).poses for side in sides]
        assert (poses[0] - poses[1]) / (2 * h) == pytest.approx(seen.jacobians[:, :, k], abs=1e-7)
        ends = [end_pose(start, side).poses for side in sides]
        assert (ends[0] - ends[1]) / (2 * h) == pytest.approx(end.jacobians[:, :, k], abs=1e-7)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_a_path_is_letters_and_letters_are_a_path(seed: int, count: int) -> None:
    """Also where long turns are cut and edges go on alike."""
    rng = np.random.default_rng(seed)
    letters = random_segments(rng, count, 2)
    letters = ArcSegments(letters.signed_lengths * 4, letters.curvatures, letters.other_positions)
    course = _problem_through(letters, rng.uniform(-1, 1, 3))
    again = course.segments
    assert len(again) == count
    assert again.variables == pytest.approx(letters.variables, abs=1e-6)
    path = course.to_path(again)
    assert path.waypoints[-1].tobytes() == course.waypoints[-1].tobytes()
    assert path.length == pytest.approx(letters.lengths.sum(), rel=1e-6)
    manifold = manifold_of(path.group)
    deltas = manifold.minus(path.waypoints[1:], path.waypoints[:-1])
    assert np.abs(deltas[:, 1]).max() < 1e-6
    assert np.abs(deltas[:, 2]).max() <= 2.0


def _problem_through(letters: ArcSegments, start: np.ndarray) -> DriveProblem:
    """A path in several edges a letter."""
    group = car_with(2)
    manifold = manifold_of(group)
    rows = [np.append(start, letters.other_positions[0])]
    for way, turn, move in zip(
        letters.signed_lengths, letters.turning_angles, letters.other_displacements, strict=True
    ):
        count = 1 + int(np.abs(turn) / 1.5)
        for _ in range(count):
            rows.append(manifold.plus(rows[-1], np.array([way, 0.0, turn, *move]) / count))
    return DriveProblem.of(JointPath(group, np.array(rows)))


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6))
def test_spots_at_shares_of_the_length_are_where_the_path_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    letters = random_segments(rng, 4, 0)
    course = DriveProblem.of(JointPath(car_with(0), _rows(letters)))
    s = np.sort(rng.uniform(0, 1, 5))
    places = sample_poses(course.start, letters, letters.samples_at(s))
    curve = course.to_path(letters).spline
    assert places.poses == pytest.approx(curve.positions(s), abs=1e-6)


def _rows(letters: ArcSegments) -> np.ndarray:
    spots, yaws = knot_poses(np.zeros(3), letters)
    return np.stack([spots.real, spots.imag, yaws], axis=1)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6))
def test_ends_are_met_without_turning_around_or_too_tightly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    letters = random_segments(rng, 4, 0)
    course = DriveProblem.of(JointPath(car_with(0), _rows(letters)))
    off = letters.with_variables(letters.variables * rng.uniform(0.95, 1.05, 8))
    met = projected_to_goal(course, off, 0.05)
    if met is None:
        return
    assert end_pose(course.start, met).poses[0] == pytest.approx(course.goal, abs=1e-10)
    assert (met.signed_lengths * letters.signed_lengths >= 0).all()
    assert np.abs(met.curvatures).max() <= 1 / RADIUS


def test_most_ends_nearby_are_met() -> None:
    rng = np.random.default_rng(0)
    found = 0
    for _ in range(40):
        letters = random_segments(rng, 5, 0)
        course = DriveProblem.of(JointPath(car_with(0), _rows(letters)))
        off = letters.with_variables(letters.variables * rng.uniform(0.98, 1.02, 10))
        found += projected_to_goal(course, off, 0.05) is not None
    assert found >= 35


def test_fewer_letters() -> None:
    others = np.array([[0.0], [1.0], [2.0], [3.0]])
    letters = ArcSegments(np.array([1.0, 2.0, -1.0]), np.array([0.5, 1.0, 0.0]), others)
    assert letters.without(0).other_positions.ravel().tolist() == [0.0, 2.0, 3.0]
    assert letters.without(2).other_positions.ravel().tolist() == [0.0, 1.0, 3.0]
    assert letters.without(2).signed_lengths.tolist() == [1.0, 2.0]
    one = letters.merged(0)
    assert one.signed_lengths.tolist() == [3.0, -1.0]
    assert one.turning_angles[0] == pytest.approx(2.5)
    assert one.other_positions.ravel().tolist() == [0.0, 2.0, 3.0]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_segment_shrinks_to_zero_and_keeps_its_direction(way: float) -> None:
    """The last segment is shorter than its share of the path's excess length."""
    no_others = np.zeros((3, 0))
    course = DriveProblem.of(JointPath(car_with(0), np.array([[0.0, 0, 0], [0.45 * way, 0, 0]])))
    off = ArcSegments(way * np.array([0.5, 0.02]), np.zeros(2), no_others)
    met = projected_to_goal(course, off, 0.1)
    assert met is not None
    assert met.signed_lengths == pytest.approx(way * np.array([0.45, 0.0]), abs=1e-9)
