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
    """Return random segments, some of them straight or short."""
    signed_lengths = rng.uniform(0.05, 0.6, count) * rng.choice([-1, 1], count)
    curvatures = rng.uniform(-1, 1, count) / RADIUS * rng.choice([0, 1, 1], count)
    return ArcSegments(signed_lengths, curvatures, rng.uniform(-1, 1, (count + 1, num_others)))


def car_with(num_arms: int, *, reverse: bool = True):
    group = group_of(JointType.PLANAR, *[JointType.REVOLUTE] * num_arms)
    return steered(group, {"r::j0": Steering(RADIUS, reverse)})


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_segments_agree_with_the_manifold(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    segments, start = random_segments(rng, count), rng.uniform(-1, 1, 3)
    manifold = manifold_of(car_with(0))
    q, expected = start, [start]
    for length, turn in zip(segments.signed_lengths, segments.turning_angles, strict=True):
        q = manifold.plus(q, np.array([length, 0.0, turn]))
        expected.append(q)
    knots, yaws = knot_poses(start, segments)
    found = np.stack([knots.real, knots.imag, yaws], axis=1)
    assert found == pytest.approx(np.array(expected), abs=1e-12)
    assert end_pose(start, segments).poses[0] == pytest.approx(expected[-1], abs=1e-12)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6), st.integers(1, 5))
def test_jacobians_are_derivatives(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    segments, start = random_segments(rng, count, 0), rng.uniform(-1, 1, 3)
    samples = PathSamples(rng.integers(0, count, 6), rng.uniform(0, 1, 6))
    at_samples, end = sample_poses(start, segments, samples), end_pose(start, segments)
    h = 1e-6
    for k in range(2 * count):
        step = h * np.eye(2 * count)[k]
        sides = [segments.with_variables(segments.variables + sign * step) for sign in (1, -1)]
        poses = [sample_poses(start, side, samples).poses for side in sides]
        assert (poses[0] - poses[1]) / (2 * h) == pytest.approx(
            at_samples.jacobians[:, :, k], abs=1e-7
        )
        ends = [end_pose(start, side).poses for side in sides]
        assert (ends[0] - ends[1]) / (2 * h) == pytest.approx(end.jacobians[:, :, k], abs=1e-7)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_paths_and_segments_are_converted_into_one_another(seed: int, count: int) -> None:
    """Also where long arcs are cut and consecutive edges are of one segment."""
    rng = np.random.default_rng(seed)
    segments = random_segments(rng, count, 2)
    segments = ArcSegments(
        segments.signed_lengths * 4, segments.curvatures, segments.other_positions
    )
    problem = _problem_through(segments, rng.uniform(-1, 1, 3))
    again = problem.segments
    assert len(again) == count
    assert again.variables == pytest.approx(segments.variables, abs=1e-6)
    path = problem.to_path(again)
    assert path.waypoints[-1].tobytes() == problem.waypoints[-1].tobytes()
    assert path.length == pytest.approx(segments.lengths.sum(), rel=1e-6)
    manifold = manifold_of(path.group)
    deltas = manifold.minus(path.waypoints[1:], path.waypoints[:-1])
    assert np.abs(deltas[:, 1]).max() < 1e-6
    assert np.abs(deltas[:, 2]).max() <= 2.0


def _problem_through(segments: ArcSegments, start: np.ndarray) -> DriveProblem:
    """Return the problem of a path with several edges per segment."""
    group = car_with(2)
    manifold = manifold_of(group)
    rows = [np.append(start, segments.other_positions[0])]
    for length, turn, move in zip(
        segments.signed_lengths, segments.turning_angles, segments.other_displacements, strict=True
    ):
        count = 1 + int(np.abs(turn) / 1.5)
        for _ in range(count):
            rows.append(manifold.plus(rows[-1], np.array([length, 0.0, turn, *move]) / count))
    return DriveProblem.of(JointPath(group, np.array(rows)))


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6))
def test_samples_at_fractions_of_the_length_are_on_the_path(seed: int) -> None:
    rng = np.random.default_rng(seed)
    segments = random_segments(rng, 4, 0)
    problem = DriveProblem.of(JointPath(car_with(0), _rows(segments)))
    s = np.sort(rng.uniform(0, 1, 5))
    at_samples = sample_poses(problem.start, segments, segments.samples_at(s))
    curve = problem.to_path(segments).spline
    assert at_samples.poses == pytest.approx(curve.positions(s), abs=1e-6)


def _rows(segments: ArcSegments) -> np.ndarray:
    knots, yaws = knot_poses(np.zeros(3), segments)
    return np.stack([knots.real, knots.imag, yaws], axis=1)


@settings(max_examples=num_cases(6))
@given(st.integers(0, 10**6))
def test_projections_end_at_the_goal_within_bounds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    segments = random_segments(rng, 4, 0)
    problem = DriveProblem.of(JointPath(car_with(0), _rows(segments)))
    off = segments.with_variables(segments.variables * rng.uniform(0.95, 1.05, 8))
    met = projected_to_goal(problem, off, 0.05)
    if met is None:
        return
    assert end_pose(problem.start, met).poses[0] == pytest.approx(problem.goal, abs=1e-10)
    assert (met.signed_lengths * segments.signed_lengths >= 0).all()
    assert np.abs(met.curvatures).max() <= 1 / RADIUS


def test_most_nearby_goals_are_reached() -> None:
    rng = np.random.default_rng(0)
    found = 0
    for _ in range(40):
        segments = random_segments(rng, 5, 0)
        problem = DriveProblem.of(JointPath(car_with(0), _rows(segments)))
        off = segments.with_variables(segments.variables * rng.uniform(0.98, 1.02, 10))
        found += projected_to_goal(problem, off, 0.05) is not None
    assert found >= 35


def test_removed_and_merged_segments() -> None:
    others = np.array([[0.0], [1.0], [2.0], [3.0]])
    segments = ArcSegments(np.array([1.0, 2.0, -1.0]), np.array([0.5, 1.0, 0.0]), others)
    assert segments.without(0).other_positions.ravel().tolist() == [0.0, 2.0, 3.0]
    assert segments.without(2).other_positions.ravel().tolist() == [0.0, 1.0, 3.0]
    assert segments.without(2).signed_lengths.tolist() == [1.0, 2.0]
    one = segments.merged(0)
    assert one.signed_lengths.tolist() == [3.0, -1.0]
    assert one.turning_angles[0] == pytest.approx(2.5)
    assert one.other_positions.ravel().tolist() == [0.0, 2.0, 3.0]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_segment_shrinks_to_zero_and_keeps_its_direction(sign: float) -> None:
    """The last segment is shorter than its share of the path's excess length."""
    no_others = np.zeros((3, 0))
    problem = DriveProblem.of(JointPath(car_with(0), np.array([[0.0, 0, 0], [0.45 * sign, 0, 0]])))
    off = ArcSegments(sign * np.array([0.5, 0.02]), np.zeros(2), no_others)
    met = projected_to_goal(problem, off, 0.1)
    assert met is not None
    assert met.signed_lengths == pytest.approx(sign * np.array([0.45, 0.0]), abs=1e-9)
