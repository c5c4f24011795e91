"""Time budgets of setup and interpolation; no solved path is lost to them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.request.deadline import Deadline
from planning.domain.request.options import SearchOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import JointType
from planning.errors import NoPathFound
from planning.search.request import SearchTask
from planning.search.solver import search
from tests.clocks import FakeClock
from tests.profiles import num_cases
from tests.search.conftest import Oracle, beyond_wall, group_of, limits_of


def task_of(seed, **options):
    start, goals = np.array([-0.8, -0.8]), np.array([[0.8, -0.5], [0.8, -0.8]])
    return SearchTask(start, goals, SearchOptions(**options), 0.05, 0.0, seed)


# By a clock that shows a second more at every look: one for the space, one for the planner.
SPENT = 2.0
PARTS = ("setup", "solve", "shortcut", "interpolate")


@pytest.mark.parametrize("planners", ["RRTConnect", ("PRM", "BITstar", "FMT")])
def test_an_attempt_whose_setup_takes_too_long_fails_with_its_times(
    plane, wall, crossing, planners
):
    task = crossing(planner=planners, attempts=3, setup_time=0.5, approximate=True)
    with pytest.raises(NoPathFound, match=r"search\.setup_time") as caught:
        search(*plane, wall, task, Deadline.after(1e9, FakeClock(step=1.0)))
    evidence = caught.value.evidence
    assert (evidence["reason"], evidence["during"], evidence["status"]) == (
        "setup",
        "setup",
        "setup",
    )
    assert (evidence["attempts"], evidence["budget"]) == (3, 0.5)
    assert evidence["spent"] == SPENT


def test_a_setup_that_takes_no_longer_than_it_may_is_fine(plane, wall, crossing):
    """The space is built once, and counts for every attempt."""
    deadline = Deadline.after(1e9, FakeClock(step=1.0))
    task = crossing(setup_time=SPENT, attempts=2)
    assert search(*plane, wall, task, deadline).report.solved == 2
    with pytest.raises(NoPathFound) as caught:
        search(*plane, wall, crossing(setup_time=SPENT - 0.1, attempts=2), deadline)
    assert caught.value.evidence["spent"] == SPENT
    assert caught.value.evidence["attempts"] == 2


def test_a_straight_line_needs_no_setup(plane, make_oracle, crossing):
    empty = make_oracle(lambda qs: np.ones(len(qs), dtype=bool))
    deadline = Deadline.after(1e9, FakeClock(step=1.0))
    assert search(*plane, empty, crossing(setup_time=0.5), deadline).report.direct


@settings(max_examples=num_cases(5))
@given(
    budget=st.sampled_from([0, 1, 300, 600, 10**6]),
    seed=st.integers(0, 3),
    num_states=st.sampled_from([50, 600]),
)
def test_interpolation_is_complete_or_omitted(budget, seed, num_states):
    """By a clock that counts the calls of the oracle."""
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
    if budget in {0, 10**6}:
        assert cut.report.interpolated == (budget > 0)


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
def test_every_stage_is_timed(plane, wall, crossing, name):
    clock = FakeClock(step=1.0)
    watch, deadline = Stopwatch(clock), Deadline.after(1e9, clock)
    search(*plane, wall, crossing(planner=name, num_states=500), deadline, watch)
    seconds = watch.seconds
    assert set(PARTS) <= set(seconds)
    assert all(seconds[part] > 0 for part in PARTS)
    assert sum(seconds[part] for part in PARTS) <= seconds["total"]
