"""Setup and interpolation keep budgets of their own, and no solved path is lost to them."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.deadline import Deadline
from planning.domain.joints import JointType
from planning.domain.options import SearchOptions
from planning.errors import NoPathFound
from planning.search import query
from planning.search.solver import search
from planning.search.spaces import SearchSpace
from planning.search.task import SearchTask
from planning.stopwatch import Stopwatch
from tests.profiles import num_cases
from tests.search.conftest import Oracle, beyond_wall, group_of, limits_of


def task_of(seed, **options):
    start, goals = np.array([-0.8, -0.8]), np.array([[0.8, -0.5], [0.8, -0.8]])
    return SearchTask(start, goals, SearchOptions(**options), 0.05, 0.0, seed)


PARTS = ("setup", "solve", "shortcut", "interpolate")


@pytest.mark.parametrize("planners", ["RRTConnect", ("PRM", "BITstar", "FMT")])
def test_an_attempt_whose_setup_takes_too_long_gives_up_and_says_so(
    plane, wall, soon, crossing, planners
):
    task = crossing(planner=planners, attempts=3, setup_time=1e-9, approximate=True)
    with pytest.raises(NoPathFound, match=r"search\.setup_time") as caught:
        search(*plane, wall, task, soon)
    told = caught.value.evidence
    assert (told["reason"], told["during"], told["status"]) == ("setup", "setup", "setup")
    assert (told["attempts"], told["budget"]) == (3, 1e-9)
    assert told["budget"] < told["spent"] < 5.0


@pytest.mark.parametrize(("budget", "is_enough"), [(0.9, False), (1.1, True)])
def test_the_space_counts_for_the_setup_of_every_attempt(
    plane, wall, crossing, monkeypatch, budget, is_enough
):
    """By a clock that stands still but while the space is built."""
    now = [0.0]

    class Slow(SearchSpace):
        def __init__(self, *how):
            now[0] += 1.0
            super().__init__(*how)

    monkeypatch.setattr(query, "SearchSpace", Slow)
    deadline = Deadline.after(100.0, lambda: now[0])
    task = crossing(setup_time=budget, attempts=2)
    if is_enough:
        assert search(*plane, wall, task, deadline).report.solved == 2
        return
    with pytest.raises(NoPathFound) as caught:
        search(*plane, wall, task, deadline)
    assert caught.value.evidence["spent"] == 1.0
    assert caught.value.evidence["attempts"] == 2


def test_a_straight_line_needs_no_setup(plane, make_oracle, soon, crossing):
    empty = make_oracle(lambda qs: np.ones(len(qs), dtype=bool))
    assert search(*plane, empty, crossing(setup_time=1e-9), soon).report.direct


@settings(max_examples=num_cases(5))
@given(
    budget=st.sampled_from([0, 1, 300, 600, 10**6]),
    seed=st.integers(0, 3),
    num_states=st.sampled_from([50, 600]),
)
def test_interpolation_is_done_or_not_and_never_by_halves(budget, seed, num_states):
    """By a clock that counts the questions of the search to the world."""
    group = group_of(JointType.PRISMATIC, JointType.PRISMATIC)

    def found(**options):
        wall = Oracle(beyond_wall)
        deadline = Deadline.after(1e9, lambda: float(len(wall.asked)))
        return search(group, limits_of(group), wall, task_of(seed, **options), deadline)

    rough, dense = found(), found(num_states=num_states)
    cut = found(num_states=num_states, interpolate_time=float(budget))
    expected = dense if cut.report.interpolated else rough
    assert cut.path.waypoints.tobytes() == expected.path.waypoints.tobytes()
    assert cut.report.num_waypoints == len(expected.path.waypoints)
    assert (len(cut.path.waypoints) >= num_states) == cut.report.interpolated
    assert budget > 0 or not cut.report.interpolated
    assert budget < 10**6 or cut.report.interpolated


def test_a_path_that_waits_for_interpolation_outlives_the_time_of_the_plan(plane, wall, crossing):
    """The clock jumps to the end once interpolation has begun: a path was found by then."""
    rough = search(*plane, wall, crossing(1), Deadline.after(1e9, lambda: 0.0))
    wall.asked.clear()
    task = crossing(1, num_states=6_000, interpolate_time=0.5)

    def clock():
        return 1e9 * float(sum(map(len, wall.asked)) > 4_000)

    found = search(*plane, wall, task, Deadline.after(10.0, clock))
    assert not found.report.interpolated
    assert found.path.waypoints.tobytes() == rough.path.waypoints.tobytes()


@pytest.mark.parametrize("name", ["RRTConnect", "RRTstar"])
def test_seconds_are_told_of_every_part(plane, wall, soon, crossing, name):
    watch = Stopwatch(time.perf_counter)
    search(*plane, wall, crossing(planner=name, num_states=500), soon, watch)
    seconds = watch.seconds
    assert set(PARTS) <= set(seconds)
    assert all(seconds[part] > 0 for part in PARTS)
    assert sum(seconds[part] for part in PARTS) <= seconds["total"]
