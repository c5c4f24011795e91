"""Shortest paths inside regions that are known."""

from itertools import pairwise

import numpy as np
import pytest

from planning.domain.planner.regions import Portal, Region, Regions
from planning.regions.corridor import corridor
from planning.regions.gcs_path import shortest_inside


def box(low, high):
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    normals = np.concatenate([np.eye(2), -np.eye(2)])
    return Region(normals, np.concatenate([high, -low]), (low + high) / 2, 100)


def regions_of(boxes, pairs):
    """Portals at the middle of what two boxes share."""
    found = tuple(box(*ends) for ends in boxes)
    portals = []
    for i, j in pairs:
        low = np.maximum(boxes[i][0], boxes[j][0])
        high = np.minimum(boxes[i][1], boxes[j][1])
        portals.append(Portal((i, j), (low + high) / 2, float((high - low).min() / 2)))
    ends = np.array([-2.0, -2.0]), np.array([2.0, 2.0])
    return Regions("s", "r", 0.0, 0, *ends, found, tuple(portals), 0.5, 0.1, "coverage")


# A U: down on the left, through the bottom, up on the right; and a longer way over the top.
U = regions_of(
    [
        ([-1.0, -1.0], [-0.5, 1.0]),
        ([-1.0, -1.0], [1.0, -0.5]),
        ([0.5, -1.0], [1.0, 1.0]),
        ([-1.0, 0.9], [-0.8, 2.0]),
        ([-1.0, 1.9], [1.0, 2.0]),
        ([0.8, 0.9], [1.0, 2.0]),
    ],
    [(0, 1), (1, 2), (0, 3), (3, 4), (4, 5), (2, 5)],
)
START, GOAL = np.array([-0.75, 0.0]), np.array([0.75, 0.0])


def length(rows):
    return np.linalg.norm(np.diff(rows, axis=0), axis=1).sum()


@pytest.mark.parametrize("max_regions", [1, 3, 6])
def test_the_path_bends_at_the_inner_corners(max_regions):
    found = shortest_inside(U, START, GOAL[None], max_regions=max_regions, max_rounded_paths=5)
    assert found.reason == ""
    assert found.goal_row == 0
    best = np.array([START, [-0.5, -0.5], [0.5, -0.5], GOAL])
    assert length(found.waypoints) == pytest.approx(length(best), abs=1e-4)
    np.testing.assert_array_equal(found.waypoints[[0, -1]], [START, GOAL])
    for q0, q1 in pairwise(found.waypoints):
        along = q0 + np.linspace(0, 1, 50)[:, None] * (q1 - q0)
        slack = [(along @ r.normals.T - r.offsets).max() for r in U.regions]
        assert min(slack) < 1e-5


def test_of_several_goals_the_one_with_the_shortest_path_is_reached():
    far = np.array([0.9, 1.95])
    found = shortest_inside(U, START, np.stack([far, GOAL]), max_regions=6, max_rounded_paths=5)
    assert found.goal_row == 1


def test_the_same_request_gives_the_same_bytes():
    first, again = (
        shortest_inside(U, START, GOAL[None], max_regions=6, max_rounded_paths=5) for _ in range(2)
    )
    np.testing.assert_array_equal(first.waypoints, again.waypoints)


@pytest.mark.parametrize(
    ("start", "goal", "reason"),
    [
        ([0.0, 0.0], GOAL, "start is outside"),
        (START, [0.0, 0.0], "goal is outside"),
        (START, [-1.9, -1.9], "not connected"),
    ],
)
def test_the_reason_for_a_missing_path_is_reported(start, goal, reason):
    island = box([-2.0, -2.0], [-1.5, -1.5])
    regions = Regions(**{**U.__dict__, "regions": (*U.regions, island)})
    goals = np.array(goal)[None]
    found = shortest_inside(regions, np.array(start), goals, max_regions=6, max_rounded_paths=5)
    assert reason in found.reason
    assert not len(found.waypoints)


def test_a_corridor_is_within_its_size_limit_except_for_its_first_path():
    goals = [(0, GOAL)]
    assert corridor(U, START, goals, 1).rows == (0, 1, 2)
    assert corridor(U, START, goals, 6).rows == (0, 1, 2, 3, 4, 5)
    pairs = corridor(U, START, goals, 6).pairs
    assert set(pairs) == {portal.regions for portal in U.portals}
