"""Guarantees of a search, with every planner."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from ompl import util as ou

from planning.domain.request.options import SearchOptions
from planning.domain.robot.joints import JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import (
    NoPathFound,
    ProblemInvalid,
    UnknownName,
)
from planning.search.solver import SearchTask, search
from tests.clocks import after_looks
from tests.profiles import seeds


def fine_samples(group, waypoints, step):
    """Configurations on the path, every corner and about `step` apart, computed independently."""
    manifold = Manifold(group.joints)
    for q0, q1 in pairwise(waypoints):
        delta = manifold.minus(q1, q0)
        count = max(1, int(np.ceil(np.linalg.norm(delta) / step - 1e-9)))
        fractions = np.arange(count + 1)[:, None] / count
        yield manifold.plus(np.tile(q0, (count + 1, 1)), fractions * delta)


def assert_sound(group, oracle, task, found):
    waypoints = found.path.waypoints
    assert waypoints[0].tobytes() == task.start.tobytes()
    assert waypoints[-1].tobytes() == task.goals[found.goal_row].tobytes()
    for qs in fine_samples(group, waypoints, task.resolution / 4):
        assert oracle.are_free(qs).all()
    assert found.report.length <= found.report.raw_length + 1e-9
    assert found.path.length == pytest.approx(found.report.length)
    assert found.report.num_waypoints == len(waypoints) >= 2


def test_a_free_straight_line_is_taken_at_once(plane, make_oracle, soon, crossing):
    empty = make_oracle(lambda qs: np.ones(len(qs), dtype=bool))
    task = crossing(seed=1, attempts=6)
    found = search(*plane, empty, task, soon)
    assert_sound(plane[0], empty, task, found)
    assert found.goal_row == 0
    assert found.report.direct
    assert (found.report.attempts, found.report.solved, found.report.attempts_log) == (0, 0, ())
    assert len(found.path.waypoints) == 2
    assert found.report.length == pytest.approx(np.linalg.norm(task.goals[0] - task.start))


def test_where_the_start_is_a_goal_there_is_nothing_to_do(plane, wall, soon, crossing):
    task = replace(crossing(), goals=np.array([[-0.8, -0.8 + 1e-10], [0.8, 0.0]]))
    found = search(*plane, wall, task, soon)
    assert_sound(plane[0], wall, task, found)
    assert found.goal_row == 0


def test_goals_that_collide_are_left_out(plane, wall, soon, crossing):
    task = replace(crossing(), goals=np.array([[0.0, 0.0], [0.05, 0.1], [0.8, -0.8]]))
    found = search(*plane, wall, task, soon)
    assert_sound(plane[0], wall, task, found)
    assert found.goal_row == 2


@pytest.mark.parametrize("inadmissible", ["start", "goals"])
def test_no_path_from_or_to_a_place_that_is_not_free(plane, wall, soon, crossing, inadmissible):
    task = crossing()
    blocked = np.zeros((1, 2))
    task = (
        replace(task, start=blocked[0]) if inadmissible == "start" else replace(task, goals=blocked)
    )
    with pytest.raises(NoPathFound) as caught:
        search(*plane, wall, task, soon)
    assert caught.value.evidence["reason"] == inadmissible


def test_no_goals_at_all_are_no_path(plane, wall, soon, crossing):
    with pytest.raises(NoPathFound):
        search(*plane, wall, replace(crossing(), goals=np.empty((0, 2))), soon)


def test_a_planner_that_gives_up_says_how_far_it_got(plane, closed, soon, crossing):
    task = crossing(planner="BFMT", parameters={"num_samples": 100}, attempts=2)
    with pytest.raises(NoPathFound) as caught:
        search(*plane, closed, task, soon)
    evidence = caught.value.evidence
    assert evidence["attempts"] == 2
    assert evidence["num_vertices"] > 100
    assert evidence["num_states_checked"] > 200


def test_more_attempts_are_never_longer(plane, wall, soon, crossing):
    one = search(*plane, wall, crossing(3), soon)
    many = search(*plane, wall, crossing(3, attempts=5), soon)
    assert many.report.solved == 5
    assert many.report.length <= one.report.length


def test_a_deadline_between_attempts_delivers_the_best_so_far(plane, wall, crossing):
    found = search(*plane, wall, crossing(attempts=10_000), after_looks(3_000))
    assert 2 < found.report.solved < 100
    assert found.report.length == min(entry.length for entry in found.report.attempts_log)
    assert_sound(plane[0], wall, crossing(), found)


@pytest.mark.parametrize("count", [2, 40, 333])
def test_the_path_has_the_requested_number_of_waypoints(plane, wall, soon, crossing, count):
    task = crossing(num_states=count)
    found = search(*plane, wall, task, soon)
    assert len(found.path.waypoints) >= count
    assert_sound(plane[0], wall, task, found)


@pytest.mark.campaign
def test_thin_obstacles_that_the_search_misses_are_not_passed(plane, make_oracle, soon, crossing):
    """Searched with steps of 0.2, a wall of 0.06 is often stepped over."""
    oracle = make_oracle(lambda qs: ~((np.abs(qs[:, 0]) < 0.03) & (qs[:, 1] < 0.8)))
    for seed in seeds(6):
        task = crossing(seed, resolution=0.2)
        assert_sound(plane[0], oracle, task, search(*plane, oracle, task, soon))


def test_waypoints_of_a_circle_do_not_jump(make_group, make_limits, make_oracle, soon):
    group = make_group(JointType.CONTINUOUS, JointType.PRISMATIC)
    oracle = make_oracle(lambda qs: ~((np.cos(qs[:, 0]) < -0.8) & (qs[:, 1] < 0.5)))
    task = SearchTask(np.array([2.0, -0.5]), np.array([[4.2, -0.5]]), SearchOptions(), 0.05, 0.0, 1)
    found = search(group, make_limits(group), oracle, task, soon)
    assert np.abs(np.diff(found.path.waypoints[:-1, 0])).max() <= np.pi + 1e-9


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"resolution": 0.0}, "search.resolution"),
        ({"resolution": float("nan")}, "search.resolution"),
        ({"seed": -1}, "seed"),
        ({"options": SearchOptions(attempts=0)}, "search.attempts"),
        ({"options": SearchOptions(num_states=1)}, "search.num_states"),
        ({"start": np.array([0.5, np.nan])}, "start"),
        ({"start": np.zeros(3), "goals": np.zeros((1, 3))}, "start"),
        ({"goals": np.array([[np.inf, 0.0]])}, "goal"),
    ],
)
def test_nonsense_is_refused(plane, wall, soon, crossing, change, field):
    with pytest.raises(ProblemInvalid) as caught:
        search(*plane, wall, replace(crossing(), **change), soon)
    assert caught.value.evidence["field"] == field


def test_an_unknown_planner_is_refused_even_if_the_line_is_free(plane, make_oracle, soon, crossing):
    empty = make_oracle(lambda qs: np.ones(len(qs), dtype=bool))
    with pytest.raises(UnknownName):
        search(*plane, empty, crossing(planner="RRTconnect"), soon)


def test_ompl_keeps_silent():
    assert ou.getLogLevel() == ou.LogLevel.LOG_NONE
