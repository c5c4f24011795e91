"""Every planner solves, repeats itself, keeps its deadline and lets itself be canceled."""

import gc
import hashlib
import random
import subprocess
import sys
import weakref
from dataclasses import replace
from functools import partial
from threading import Event

import numpy as np
import pytest

from planning.domain.request.deadline import Deadline
from planning.domain.request.options import SearchOptions
from planning.domain.robot.joints import JointType
from planning.errors import Canceled, DeadlineExceeded
from planning.search.ompl.planner_list import planner_names
from planning.search.solver import SearchTask, search
from tests.clocks import FakeClock, no_hurry
from tests.profiles import pairs
from tests.search.conftest import (
    Oracle,
    beyond_wall,
    each_kind_of_planner,
    group_of,
    limits_of,
)
from tests.search.test_solver import assert_sound

EVERY_PLANNER = pytest.mark.parametrize("name", planner_names())


class Busy(Oracle):
    """The wall on a busy machine: now and then an answer takes a while."""

    def __init__(self):
        super().__init__(beyond_wall)
        self._waits = random.Random(0)

    def is_motion_free(self, origin, displacement, resolution):
        if self._waits.random() < 0.02:
            Event().wait(0.001)
        return super().is_motion_free(origin, displacement, resolution)


@EVERY_PLANNER
def test_every_planner_solves_and_repeats_itself(plane, crossing, name):
    """Time changes no byte, neither the machine's nor that of the clock, and who listens neither.

    Planners that improve their path would use up any time that they are given.
    """
    task = crossing(5, planner=name)
    idle, busy, told = Oracle(beyond_wall), Busy(), []
    quick = search(*plane, idle, task, no_hurry())
    assert_sound(plane[0], idle, task, quick)
    assert quick.report.solved == 1
    assert not quick.report.direct
    hours = Deadline.after(1e9, FakeClock(step=7.0))
    slow = search(*plane, busy, replace(task, on_best=told.append), hours)
    assert slow.path.waypoints.tobytes() == quick.path.waypoints.tobytes()
    assert slow.report == quick.report


@EVERY_PLANNER
def test_every_planner_keeps_the_deadline(plane, make_oracle, crossing, name):
    clock, late = FakeClock(step=1.0), []

    def are_free(qs):
        late.append(clock.now > 400.0)
        return np.abs(qs[:, 0]) > 0.1

    deadline = Deadline.after(400.0, clock)
    with pytest.raises(DeadlineExceeded) as caught:
        search(*plane, make_oracle(are_free), crossing(planner=name), deadline)
    assert caught.value.evidence["planner"] == name
    assert caught.value.evidence["num_states_checked"] > 100
    # The oracle is not called any more, and the clock rarely.
    assert sum(late) <= 1
    assert clock.now < 420.0


@EVERY_PLANNER
def test_a_cancel_ends_every_planner(plane, closed, crossing, name):
    looks = []

    def is_canceled():
        looks.append(len(closed.asked))
        return len(closed.asked) > 100

    with pytest.raises(Canceled):
        search(*plane, closed, crossing(planner=name), no_hurry(30.0, is_canceled))
    assert len(closed.asked) <= 110
    assert sum(count > 100 for count in looks) < 20


@EVERY_PLANNER
def test_errors_of_the_oracle_pass_through_the_planner(plane, make_oracle, soon, crossing, name):
    calls = []

    def are_free(qs):
        calls.append(len(qs))
        if len(calls) > 60:
            message = "the world broke"
            raise KeyError(message)
        return np.abs(qs[:, 0]) > 0.1

    with pytest.raises(KeyError, match="the world broke"):
        search(*plane, make_oracle(are_free), crossing(planner=name), soon)


# What is held as well: objectives of ours in Python, and what was grown.
KEEPING = (("length", False), ("duration", True))


@pytest.mark.campaign
def test_searches_leave_nothing_behind(plane, soon, crossing):
    """OMPL keeps the edge checker, which keeps the oracle: neither may outlive the search."""
    remembered = {}
    for name, (objective, keep_graph) in pairs(planner_names(), KEEPING):
        few = {"num_samples": 200} if name in {"FMT", "BFMT"} else {}
        oracle = Oracle(beyond_wall)
        remembered[name, objective] = weakref.ref(oracle)
        options = {"objective": objective, "keep_graph": keep_graph, "parameters": few}
        search(*plane, oracle, crossing(planner=name, **options), soon)
        del oracle
    gc.collect()
    assert [search for search, oracle in remembered.items() if oracle() is not None] == []


@each_kind_of_planner
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


@each_kind_of_planner
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


@partial(each_kind_of_planner, among=("RRTConnect",))
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


@each_kind_of_planner
def test_a_mixed_group_finds_its_way(make_group, make_limits, make_oracle, soon, name):
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


def digests():
    """Yield the path of every planner around the wall, as text."""
    group = group_of(JointType.PRISMATIC, JointType.PRISMATIC)
    for name in planner_names():
        few = {"num_samples": 200} if name in {"FMT", "BFMT"} else {}
        task = SearchTask(
            np.array([-0.8, -0.8]),
            np.array([[0.8, -0.8]]),
            SearchOptions(planner=name, parameters=few),
            0.05,
            0.0,
            7,
        )
        found = search(group, limits_of(group), Oracle(beyond_wall), task, no_hurry())
        yield f"{name} {hashlib.sha256(found.path.waypoints.tobytes()).hexdigest()} {found.report}"


PROGRAM = """
from tests.search.test_every_planner import digests
print(*digests(), sep="\\n")
"""


def test_a_fresh_process_gives_the_same_bytes_and_nothing_on_the_terminal():
    """The same as this one, which has searched for much else before."""
    fresh = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True, timeout=240
    )
    assert fresh.stdout.splitlines() == list(digests())
    assert fresh.stderr == ""
