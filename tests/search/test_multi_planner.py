"""Several planners take turns, by counts; budgets are kept; a cancel may leave the best."""

from dataclasses import replace

import numpy as np
import pytest

from planning.domain.curves.motion_samples import num_steps
from planning.domain.request.deadline import Deadline
from planning.errors import Canceled, DeadlineExceeded, NoPathFound, ProblemInvalid, UnknownName
from planning.search.solver import search
from tests.clocks import FakeClock, no_hurry
from tests.search.conftest import Oracle

# States that an attempt of several planners may check in the first round.
FIRST_ROUND = 20_000
THREE = ("RRTConnect", "PRM", "KPIECE1")


def test_each_planner_has_its_turn_and_the_best_wins(plane, wall, soon, crossing):
    found = search(*plane, wall, crossing(planner=THREE, attempts=5), soon)
    log = found.report.attempts_log
    assert [entry.planner for entry in log] == [*THREE, *THREE[:2]]
    solved = [entry for entry in log if entry.outcome == "solved"]
    assert (found.report.attempts, found.report.solved) == (len(log), len(solved))
    best = min(solved, key=lambda entry: entry.length)
    assert (found.report.planner, found.report.length) == (best.planner, best.length)
    assert sum(entry.num_states_checked for entry in log) <= found.report.num_states_checked


def test_a_portfolio_repeats_itself(plane, wall, soon, crossing):
    a, b = (search(*plane, wall, crossing(4, planner=THREE), soon) for _ in range(2))
    assert a.path.waypoints.tobytes() == b.path.waypoints.tobytes()
    assert a.report == b.report
    assert a.report.attempts == 3


def test_a_portfolio_of_one_is_that_planner(plane, wall, soon, crossing):
    a, b = (search(*plane, wall, crossing(4, planner=name), soon) for name in ("PRM", ("PRM",)))
    assert a.path.waypoints.tobytes() == b.path.waypoints.tobytes()


class Measured(Oracle):
    """Counts states as a search does: all of a motion, looked at or not."""

    def __init__(self, are_free):
        super().__init__(are_free)
        self.num_states = 0

    def is_motion_free(self, origin, displacement, resolution):
        self.num_states += num_steps(displacement, resolution)
        return super().is_motion_free(origin, displacement, resolution)

    def clock(self):
        return float(self.num_states)


def test_a_planner_that_is_stuck_leaves_the_others_their_turn(plane, make_oracle, soon, crossing):
    """RRT does not come through a gap of 0.05 at the far end soon; PRM has its turn."""
    oracle = make_oracle(lambda qs: ~((np.abs(qs[:, 0]) < 0.1) & (qs[:, 1] < 0.95)))
    task = crossing(planner=("RRT", "PRM"), seed=1, resolution=0.001)
    found = search(*plane, oracle, task, soon)
    log = found.report.attempts_log
    first = log[0]
    assert (first.planner, first.outcome) == ("RRT", "Approximate solution")
    # A motion that was begun is finished: no more than 3 m of it.
    assert FIRST_ROUND <= first.num_states_checked < FIRST_ROUND + 3_000
    assert [entry.planner for entry in log[:2]] == ["RRT", "PRM"]
    assert found.report.solved >= 1


def test_those_that_fail_begin_anew_with_four_times_as_many(plane, crossing):
    """By a clock that counts states: twice 20,000, then 80,000, then more than there is time for.

    No planner solves it, so that the rounds go on until the time is up.
    """
    oracle = Measured(lambda qs: np.abs(qs[:, 0]) > 0.1)
    deadline = Deadline.after(8.0 * FIRST_ROUND, oracle.clock)
    task = crossing(planner=("RRT", "RRTConnect"), resolution=0.001)
    with pytest.raises(DeadlineExceeded) as caught:
        search(*plane, oracle, task, deadline)
    assert caught.value.evidence["attempts"] == 4
    assert caught.value.evidence["num_given_up"] == 1
    assert caught.value.evidence["planner"] == "RRT, RRTConnect"


def test_planners_that_end_by_themselves_end_the_race(plane, closed, soon, crossing):
    options = {"planner": ("BFMT", "BFMT"), "parameters": {"num_samples": 60}}
    with pytest.raises(NoPathFound) as caught:
        search(*plane, closed, crossing(**options), soon)
    assert caught.value.evidence["attempts"] == 2


def test_parameters_go_to_those_that_have_them(plane, wall, soon, crossing):
    task = crossing(planner=("RRTConnect", "FMT"), parameters={"num_samples": 300})
    assert search(*plane, wall, task, soon).report.solved == 2
    with pytest.raises(UnknownName) as caught:
        search(*plane, wall, crossing(planner=THREE, parameters={"num_sample": 3}), soon)
    assert caught.value.evidence["kind"] == "parameter"
    with pytest.raises(ProblemInvalid):
        search(*plane, wall, crossing(planner=THREE, parameters={"range": -1.0}), soon)
    with pytest.raises(UnknownName, match="RRTConnect"):
        search(*plane, wall, crossing(planner=("PRM", "RRTconnect")), soon)


def test_the_budget_of_the_planner_is_kept_per_attempt(plane, closed, crossing):
    clock = FakeClock(step=1.0)
    task = crossing(solve_time=500.0, attempts=3)
    with pytest.raises(NoPathFound) as caught:
        search(*plane, closed, task, Deadline.after(1e9, clock))
    assert 1_500.0 <= clock.now < 1_700.0
    assert caught.value.evidence["attempts"] == 3


def test_no_time_for_shortcuts_leaves_the_path_as_it_was_found(plane, wall, soon, crossing):
    rough = search(*plane, wall, crossing(1, shortcut_time=0.0), soon)
    assert rough.report.length == pytest.approx(rough.report.raw_length)
    smooth = search(*plane, wall, crossing(1), soon)
    assert smooth.report.raw_length == rough.report.raw_length
    assert smooth.report.length < rough.report.length


@pytest.mark.parametrize("objective", ["length", "duration"])
def test_budgets_that_cut_nothing_change_no_byte(plane, wall, soon, crossing, objective):
    options = {"objective": objective, "attempts": 2, "num_states": 300}
    free = search(*plane, wall, crossing(3, **options), soon)
    budgets = dict.fromkeys(("setup_time", "solve_time", "shortcut_time", "interpolate_time"), 9.0)
    limited = crossing(3, **options, **budgets, approximate=True)
    bound = search(*plane, wall, limited, soon)
    assert free.path.waypoints.tobytes() == bound.path.waypoints.tobytes()
    assert free.report == bound.report


def test_weights_of_one_and_wide_bounds_change_no_byte(plane, wall, soon, crossing):
    plain = search(*plane, wall, crossing(3), soon)
    same = crossing(3, weights={"r::j0": 1.0}, bounds={"r::j1": (-7.0, 7.0)}, keep_graph=True)
    found = search(*plane, wall, same, soon)
    assert plain.path.waypoints.tobytes() == found.path.waypoints.tobytes()
    assert plain.report == found.report


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("setup_time", 0.0),
        ("solve_time", 0.0),
        ("shortcut_time", -1.0),
        ("interpolate_time", -1.0),
        ("planner", ()),
    ],
)
def test_nonsense_is_refused(plane, wall, soon, crossing, option, value):
    with pytest.raises(ProblemInvalid) as caught:
        search(*plane, wall, crossing(**{option: value}), soon)
    assert caught.value.evidence["field"] == f"search.{option}"


def test_every_better_path_is_reported(plane, wall, soon, crossing):
    reports = []
    task = replace(crossing(2, attempts=6), on_best=reports.append)
    found = search(*plane, wall, task, soon)
    lengths = [best.attempt.length for best in reports]
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[-1] == found.report.length
    for best in reports:
        steps = np.linalg.norm(np.diff(best.waypoints, axis=0), axis=1)
        assert steps.sum() == pytest.approx(best.attempt.length)
    np.testing.assert_array_equal(reports[-1].waypoints, found.path.waypoints)


def canceled_after_best(on_cancel, crossing):
    reports = []
    task = crossing(2, attempts=50, on_cancel=on_cancel)
    deadline = no_hurry(30.0, lambda: bool(reports))
    return replace(task, on_best=reports.append), deadline


def test_a_cancel_with_best_returns_the_best_path(plane, wall, crossing):
    task, deadline = canceled_after_best("best", crossing)
    found = search(*plane, wall, task, deadline)
    assert found.report.was_canceled
    assert found.report.solved == 1
    task, deadline = canceled_after_best("discard", crossing)
    with pytest.raises(Canceled):
        search(*plane, wall, task, deadline)


def test_a_cancel_before_there_is_anything_cancels(plane, closed, crossing):
    deadline = no_hurry(30.0, lambda: len(closed.asked) > 50)
    with pytest.raises(Canceled):
        search(*plane, closed, crossing(on_cancel="best"), deadline)
