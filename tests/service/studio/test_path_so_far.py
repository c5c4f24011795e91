"""The best path of a search as the studio draws it, before there is one that is proven."""

import numpy as np
import pytest

from service.studio.plans.path_so_far import along
from tests.profiles import rng_of, seeds


@pytest.mark.campaign
@pytest.mark.parametrize("seed", seeds(3))
def test_points_lie_on_the_path_and_as_far_from_each_other_along_it(seed):
    rng = rng_of(seed)
    waypoints = rng.normal(size=(int(rng.integers(2, 9)), 4))
    rows = along(waypoints, ["a", "b", "c", "d"], 201)
    np.testing.assert_allclose(rows[[0, -1]], waypoints[[0, -1]], atol=1e-12)
    length = np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum()
    steps = np.linalg.norm(np.diff(rows, axis=0), axis=1)
    # a step over a corner is shorter
    assert steps.max() <= length / 200 + 1e-9
    assert np.sum(steps < length / 200 - 1e-9) <= len(waypoints) - 2
    first, edge = waypoints[:-1], np.diff(waypoints, axis=0)
    share = np.einsum("rek,ek->re", rows[:, None] - first, edge) / (edge**2).sum(axis=1)
    nearest = first + np.clip(share, 0, 1)[..., None] * edge
    assert np.linalg.norm(rows[:, None] - nearest, axis=2).min(axis=1).max() < 1e-9


def test_quaternions_between_waypoints_have_length_1():
    turn = np.sqrt(0.5)
    waypoints = np.array([[0.3, 1, 0, 0, 0, 5.0], [0.4, turn, turn, 0, 0, 7.0]])
    names = ["arm", *(f"body.{name}" for name in ("qw", "qx", "qy", "qz", "x"))]
    rows = along(waypoints, names, 7)
    np.testing.assert_allclose(np.linalg.norm(rows[:, 1:5], axis=1), 1.0)
    np.testing.assert_allclose(rows[[0, -1]], waypoints, atol=1e-12)


def test_a_path_that_stands_still_is_drawn_as_a_point():
    rows = along(np.ones((2, 3)), ["a", "b", "c"], 5)
    np.testing.assert_array_equal(rows, np.ones((5, 3)))
