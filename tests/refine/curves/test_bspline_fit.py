"""The guess follows the path, meets its ends and does not jump by whole turns."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import Joint, JointGroup, JointType
from planning.refine.curves.bspline_basis import make_bspline
from planning.refine.curves.bspline_fit import fit_control_points, unwrapped_waypoints


def path_of(waypoints: np.ndarray, kind: JointType) -> JointPath:
    joints = tuple(Joint(f"g::j{i}", kind) for i in range(waypoints.shape[1]))
    return JointPath(JointGroup("g", joints, ()), waypoints)


@given(seed=st.integers(0, 2**32 - 1))
def test_unwrapped_angles_step_by_less_than_half_a_turn(seed):
    waypoints = np.random.default_rng(seed).uniform(-np.pi, np.pi, (6, 3))
    angles = unwrapped_waypoints(path_of(waypoints, JointType.CONTINUOUS))
    np.testing.assert_array_equal(angles[0], waypoints[0])
    assert (np.abs(np.diff(angles, axis=0)) <= np.pi + 1e-9).all()
    turns = (angles - waypoints) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)


def test_repeated_waypoints_are_merged():
    waypoints = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.5], [1.0, 0.5], [2.0, 0.0]])
    kept = unwrapped_waypoints(path_of(waypoints, JointType.REVOLUTE))
    np.testing.assert_array_equal(kept, waypoints[[0, 2, 4]])


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 4))
def test_the_fit_meets_the_ends_and_stays_near_the_path(seed, count):
    steps = np.random.default_rng(seed).uniform(-0.5, 0.5, (count, 4))
    waypoints = np.cumsum(steps, axis=0)
    points = fit_control_points(waypoints, np.array([1.0, 2.0, 1.0, 3.0]))
    np.testing.assert_array_equal(points[[0, -1]], waypoints[[0, -1]])
    curve = make_bspline(points).vector_values(np.linspace(0, 1, 200)).T
    dense = np.vstack([np.linspace(a, b, 200) for a, b in pairwise(waypoints)])
    gaps = np.linalg.norm(curve[:, None] - dense[None], axis=2).min(axis=1)
    assert gaps.max() < 0.15


def test_a_straight_path_is_fitted_exactly():
    waypoints = np.array([[0.0, 1.0], [2.0, -1.0]])
    points = fit_control_points(waypoints, np.ones(2))
    s = np.linspace(0, 1, 50)
    curve = make_bspline(points).vector_values(s).T
    np.testing.assert_allclose(curve, [0.0, 1.0] + s[:, None] * [2.0, -2.0], atol=1e-12)
