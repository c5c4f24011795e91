"""Every planner solves, repeats, keeps its deadline and lets itself be canceled."""

import subprocess
import sys
import time
import weakref
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from ompl import util as ou

from planning.domain.deadline import Deadline
from planning.domain.joints import JointType
from planning.domain.manifold import Manifold
from planning.domain.options import SearchOptions
from planning.errors import (
    Canceled,
    DeadlineExceeded,
    NoPathFound,
    ProblemInvalid,
    UnknownName,
)
from planning.search.planners import planner_names
from planning.search.solver import SearchTask, search
from tests.clocks import no_hurry


def fine_samples(group, waypoints, step):
    """Configurations on the path, every corner and about `step` apart, by a way of its own."""
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


@pytest.mark.parametrize("name", planner_names())
def test_every_planner_solves_a_planar_problem(plane, wall, soon, crossing, name):
    task = crossing(planner=name)
    found = search(*plane, wall, task, soon)
    assert_sound(plane[0], wall, task, found)
    assert found.report.solved == 1
    assert not found.report.direct


@pytest.mark.parametrize("name", planner_names())
def test_every_planner_repeats_itself(plane, wall, soon, crossing, name):
    a, b = (search(*plane, wall, crossing(5, planner=name), soon) for _ in range(2))
    assert a.path.waypoints.tobytes() == b.path.waypoints.tobytes()
    assert a.report == b.report


@pytest.mark.parametrize("name", planner_names())
def test_every_planner_keeps_the_deadline(plane, closed, crossing, name):
    deadline = Deadline.after(0.3, time.perf_counter)
    began = time.perf_counter()
    with pytest.raises((DeadlineExceeded, NoPathFound)) as caught:
        search(*plane, closed, crossing(planner=name), deadline)
    assert time.perf_counter() - began < 1.0
    assert caught.value.evidence["planner"] == name
    assert caught.value.evidence["num_states_checked"] > 0


@pytest.mark.parametrize("name", planner_names())
def test_a_cancel_ends_every_planner(plane, closed, crossing, name):
    began = time.perf_counter()

    def is_canceled():
        return time.perf_counter() > began + 0.02

    with pytest.raises(Canceled):
        search(
            *plane,
            closed,
            crossing(planner=name),
            no_hurry(30.0, is_canceled),
        )
    assert time.perf_counter() - began < 1.0


@pytest.mark.parametrize("name", planner_names())
def test_what_the_oracle_raises_comes_out(plane, make_oracle, soon, crossing, name):
    calls = []

    def are_free(qs):
        calls.append(len(qs))
        if len(calls) > 60:
            message = "the world broke"
            raise KeyError(message)
        return np.abs(qs[:, 0]) > 0.1

    with pytest.raises(KeyError, match="the world broke"):
        search(*plane, make_oracle(are_free), crossing(planner=name), soon)


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


@pytest.mark.parametrize("name", planner_names())
def test_the_goal_that_can_be_reached_is_found_among_those_that_cannot(
    plane, make_oracle, soon, crossing, name
):
    def are_free(qs):
        boxed = np.abs(np.abs(qs - [0.6, 0.6]).max(axis=1) - 0.2) > 0.05
        return boxed & ~((np.abs(qs[:, 0]) < 0.1) & (qs[:, 1] < 0.6))

    oracle = make_oracle(are_free)
    goals = np.array([[0.6, 0.6], [0.55, 0.6], [0.8, -0.8]])
    task = replace(crossing(planner=name), goals=goals)
    found = search(*plane, oracle, task, soon)
    assert_sound(plane[0], oracle, task, found)
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
    deadline = Deadline.after(0.5, time.perf_counter)
    found = search(*plane, wall, crossing(attempts=10_000), deadline)
    assert 1 <= found.report.solved < 10_000
    assert_sound(plane[0], wall, crossing(), found)


@pytest.mark.parametrize("count", [2, 40, 333])
def test_the_path_has_as_many_waypoints_as_were_asked_for(plane, wall, soon, crossing, count):
    task = crossing(num_states=count)
    found = search(*plane, wall, task, soon)
    assert len(found.path.waypoints) >= count
    assert_sound(plane[0], wall, task, found)


def test_thin_obstacles_that_the_search_misses_are_not_passed(plane, make_oracle, soon, crossing):
    """Searched with steps of 0.2, a wall of 0.06 is often stepped over."""
    oracle = make_oracle(lambda qs: ~((np.abs(qs[:, 0]) < 0.03) & (qs[:, 1] < 0.8)))
    for seed in range(12):
        task = crossing(seed, resolution=0.2)
        assert_sound(plane[0], oracle, task, search(*plane, oracle, task, soon))


@pytest.mark.parametrize("name", planner_names())
def test_an_l_turns_through_a_slit(make_group, make_limits, slit, soon, name):
    group = make_group(JointType.PLANAR)
    task = SearchTask(
        np.array([-0.6, -0.4, 1.5]),
        np.array([[0.4, 0.4, 3.0], [0.5, 0.3, -3.0 + 4 * np.pi]]),
        SearchOptions(planner=name),
        0.05,
        0.0,
        2,
    )
    assert_sound(group, slit, task, search(group, make_limits(group), slit, task, soon))


@pytest.mark.parametrize("name", ["RRTConnect", "PRM", "KPIECE1", "BITstar", "RRT"])
def test_a_bar_flies_through_a_window(make_group, make_limits, window, soon, name):
    group = make_group(JointType.FLOATING)
    upright = [1.0, 0.0, 0.0, 0.0]
    task = SearchTask(
        np.array([*upright, -0.7, 0.1, 0.0]),
        np.array([[*upright, 0.7, 0.2, 0.1]]),
        SearchOptions(planner=name),
        0.05,
        0.0,
        0,
    )
    found = search(group, make_limits(group), window, task, soon)
    assert_sound(group, window, task, found)
    norms = np.linalg.norm(found.path.waypoints[:, :4], axis=1)
    assert np.abs(norms - 1).max() < 1e-9


@pytest.mark.parametrize("name", planner_names())
def test_every_planner_takes_a_mixed_group(make_group, make_limits, make_oracle, soon, name):
    group = make_group(JointType.CONTINUOUS, JointType.PRISMATIC, JointType.CONTINUOUS)
    oracle = make_oracle(lambda qs: ~((np.cos(qs[:, 0]) > 0.8) & (qs[:, 1] < 0.5)))
    task = SearchTask(
        np.array([-1.0, -0.5, 3.0]),
        np.array([[1.0, -0.5, -3.0 + 6 * np.pi]]),
        SearchOptions(planner=name),
        0.05,
        0.0,
        1,
    )
    assert_sound(group, oracle, task, search(group, make_limits(group), oracle, task, soon))


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


def test_an_unknown_planner_is_refused_even_if_the_way_is_free(plane, make_oracle, soon, crossing):
    empty = make_oracle(lambda qs: np.ones(len(qs), dtype=bool))
    with pytest.raises(UnknownName):
        search(*plane, empty, crossing(planner="RRTconnect"), soon)


PROGRAM = """
import hashlib
import numpy as np
from planning.domain import motion_samples
from planning.domain.joints import Joint, JointGroup, JointLimits, JointType
from planning.domain.manifold import Manifold
from planning.domain.options import SearchOptions
from planning.search.planners import planner_names
from planning.search.solver import SearchTask, search
from tests.clocks import no_hurry

group = JointGroup("r", (Joint("r::p", JointType.PLANAR), Joint("r::z", JointType.PRISMATIC)), ())
MANIFOLD = Manifold(group.joints)
upper, one = np.array([1.0, 1.0, np.inf, 1.0]), np.ones(3)
limits = JointLimits(-upper, upper, one, one, one, one, ((0, 1), (2,), (3,)))

class Wall:
    def is_free(self, q):
        return bool(self.are_free(q[None])[0])
    def are_free(self, qs):
        return ~((np.abs(qs[:, 0]) < 0.1) & (qs[:, 1] + 0.1 * np.cos(qs[:, 2]) < 0.6))
    def is_motion_free(self, *motion_and_resolution):
        *motion, step = motion_and_resolution
        return motion_samples.is_motion_free(MANIFOLD, self.are_free, tuple(motion), step)
    def are_motions_free(self, *motions_and_resolution):
        *motions, step = motions_and_resolution
        return motion_samples.are_motions_free(MANIFOLD, self.are_free, tuple(motions), step)

for name in planner_names():
    task = SearchTask(
        np.array([-0.8, -0.8, 0.0, 0.2]), np.array([[0.8, -0.8, 2.0, 0.0]]),
        SearchOptions(planner=name, attempts=1), 0.05, 0.0, 7,
    )
    found = search(group, limits, Wall(), task, no_hurry(30.0))
    print(name, hashlib.sha256(found.path.waypoints.tobytes()).hexdigest(), found.report)
"""


@pytest.mark.slow
def test_fresh_processes_give_the_same_bytes_and_nothing_on_the_terminal():
    runs = [
        subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert runs[0].stdout == runs[1].stdout
    assert len(runs[0].stdout.splitlines()) == len(planner_names())
    assert runs[0].stderr == ""


@pytest.mark.parametrize("options", [{}, {"objective": "duration", "keep_graph": True}])
@pytest.mark.parametrize("name", planner_names())
def test_searches_leave_nothing_of_ompl_behind(plane, wall, crossing, name, options, monkeypatch):
    from planning.search import motions

    alive = []

    def counted(validator):
        class Counted(validator):
            def __init__(self, *args):
                super().__init__(*args)
                self.marker = type("Marker", (), {})()
                alive.append(weakref.ref(self.marker))

        return Counted

    for validator in ("EdgeMotionValidator", "WholeEdgeValidator"):
        monkeypatch.setattr(motions, validator, counted(getattr(motions, validator)))
    parameters = {"num_samples": 200} if name in {"FMT", "BFMT"} else {}
    soon = no_hurry(10.0)
    search(*plane, wall, crossing(planner=name, parameters=parameters, **options), soon)
    assert alive
    assert sum(reference() is not None for reference in alive) == 0


def test_ompl_keeps_silent():
    assert ou.getLogLevel() == ou.LogLevel.LOG_NONE
