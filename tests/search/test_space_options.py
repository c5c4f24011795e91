"""Weights, bounds and held rotations are named, checked and kept."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.request.options import SearchOptions
from planning.domain.robot.joints import JointType
from planning.errors import NoPathFound, ProblemInvalid, UnknownName
from planning.search.solver import SearchTask, search
from planning.search.space_options import bounded_limits, held_rotations, metric_weights

KINDS = (JointType.REVOLUTE, JointType.PLANAR, JointType.FLOATING)


def test_a_blocks_own_weight_beats_that_of_its_joint(make_group):
    weights = {"r::j1": 3.0, "r::j1.angular": 0.5, "r::j0": 2.0}
    assert metric_weights(make_group(*KINDS), weights).tolist() == [2.0, 3.0, 0.5, 1.0, 1.0]


def test_bounds_only_tighten(make_group, make_limits):
    group = make_group(*KINDS)
    limits = make_limits(group)
    tight = bounded_limits(group, limits, {"r::j0": (-5.0, 0.5), "r::j1.yaw": (0.0, 1.0)})
    assert tight.lower[0] == -1.0
    assert tight.upper[[0, 3]].tolist() == [0.5, 1.0]
    untouched = [i for i in range(group.num_positions) if i not in {0, 3}]
    assert tight.lower[untouched].tolist() == limits.lower[untouched].tolist()


@pytest.mark.parametrize(
    ("weights", "bounds", "spaces", "error"),
    [
        ({"r::j7": 1.0}, {}, {}, UnknownName),
        ({"r::j0": 0.0}, {}, {}, ProblemInvalid),
        ({"r::j0": float("nan")}, {}, {}, ProblemInvalid),
        ({}, {"r::j1": (0.0, 1.0)}, {}, UnknownName),
        ({}, {"r::j0": (0.5, 0.4)}, {}, ProblemInvalid),
        ({}, {"r::j0": (1.5, 1.6)}, {}, ProblemInvalid),
        ({}, {"r::j0": (float("nan"), 0.4)}, {}, ProblemInvalid),
        ({}, {"r::j2.qw": (0.0, 1.0)}, {}, ProblemInvalid),
        ({}, {}, {"r::j0": "position"}, UnknownName),
        ({}, {}, {"r::j1": "dubins"}, UnknownName),
    ],
)
def test_nonsense_is_refused(make_group, make_limits, weights, bounds, spaces, error):
    group = make_group(*KINDS)

    def demand():
        metric_weights(group, weights)
        bounded_limits(group, make_limits(group), bounds)
        held_rotations(group, spaces)

    with pytest.raises(error) as caught:
        demand()
    told = caught.value.evidence
    assert told["field" if error is ProblemInvalid else "kind"]


@pytest.mark.parametrize("planner", ["RRTConnect", "PRM", "BITstar", "LBKPIECE1"])
def test_a_search_stays_within_its_bounds(plane, make_oracle, soon, crossing, planner):
    oracle = make_oracle(lambda qs: ~((np.abs(qs[:, 0]) < 0.1) & (np.abs(qs[:, 1]) < 0.6)))
    for sign in (1.0, -1.0):
        low, high = sorted((-0.3 * sign, 0.95 * sign))
        task = crossing(planner=planner, bounds={"r::j1": (low, high)})
        ends = np.array([-0.8, 0.0]), np.array([[0.8, 0.0]])
        found = search(*plane, oracle, replace(task, start=ends[0], goals=ends[1]), soon)
        y = found.path.waypoints[:, 1]
        assert y.min() >= low
        assert y.max() <= high
        assert np.abs(y).max() > 0.6


def test_goals_beyond_the_bounds_are_no_goals(plane, wall, soon, crossing):
    with pytest.raises(NoPathFound) as caught:
        search(*plane, wall, crossing(bounds={"r::j0": (-1.0, 0.5)}), soon)
    assert caught.value.evidence["reason"] == "goals"
    assert "bounds" in caught.value.detail


@pytest.mark.parametrize("kind", [JointType.PLANAR, JointType.FLOATING])
@pytest.mark.parametrize("planner", ["RRTConnect", "PRM", "KPIECE1"])
def test_a_held_rotation_stays(make_group, make_limits, make_oracle, soon, kind, planner):
    group = make_group(kind, JointType.REVOLUTE)
    is_planar = kind is JointType.PLANAR
    turn = [0.7] if is_planar else [0.8, 0.0, 0.6, 0.0]
    first = 0 if is_planar else 4

    def are_free(qs):
        return ~((np.abs(qs[:, first]) < 0.1) & (qs[:, first + 1] < 0.5))

    ends = np.array([[-0.7, -0.7, *turn, 0.2], [0.7, -0.6, *turn, -0.4]])
    if not is_planar:
        ends = np.array([[*turn, -0.7, -0.7, 0.3, 0.2], [*turn, 0.7, -0.6, 0.1, -0.4]])
    turned = ends[1].copy()
    turned[2 if is_planar else 0] *= -0.5 if is_planar else 0.5
    task = SearchTask(
        ends[0],
        np.stack([turned, ends[1]]),
        SearchOptions(planner=planner, spaces={"r::j0": "position"}, weights={"r::j1": 2.0}),
        0.05,
        0.0,
        3,
    )
    found = search(group, make_limits(group), make_oracle(are_free, group), task, soon)
    rows = [2] if is_planar else [0, 1, 2, 3]
    assert np.abs(found.path.waypoints[:, rows] - turn).max() < 1e-9
    assert found.goal_row == 1
    assert not found.report.direct


@pytest.mark.parametrize("weight", [0.2, 5.0])
def test_weights_change_the_search_and_not_the_free_set(plane, wall, soon, crossing, weight):
    plain = search(*plane, wall, crossing(2), soon)
    task = crossing(2, weights={"r::j1": weight})
    found = search(*plane, wall, task, soon)
    assert found.path.waypoints.tobytes() != plain.path.waypoints.tobytes()
    again = search(*plane, wall, task, soon)
    assert found.path.waypoints.tobytes() == again.path.waypoints.tobytes()


def test_a_heavy_joint_is_moved_less(make_group, make_limits, make_oracle, soon):
    """Around a block that can be passed by y or by z, the light one is taken."""
    group = make_group(*[JointType.PRISMATIC] * 3)
    inside = 0.4

    def are_free(qs):
        return ~((np.abs(qs[:, 0]) < 0.2) & (np.abs(qs[:, 1:]) < inside).all(axis=1))

    travels = []
    for heavy in ("r::j1", "r::j2"):
        options = SearchOptions(
            objective="weighted_length", weights={heavy: 20.0}, planner="BITstar"
        )
        task = SearchTask(
            np.array([-0.8, 0.0, 0.0]), np.array([[0.8, 0.0, 0.0]]), options, 0.05, 0.0, 1
        )
        found = search(group, make_limits(group), make_oracle(are_free), task, soon)
        travels.append(np.abs(np.diff(found.path.waypoints, axis=0)).sum(axis=0)[1:])
    assert travels[0][0] < 0.1 < travels[0][1]
    assert travels[1][1] < 0.1 < travels[1][0]
