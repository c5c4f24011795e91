"""Concurrent attempts: the same bytes as one after another, whichever child dies."""

import os
import signal
import threading
from dataclasses import replace

import pytest

from planning.domain.request.deadline import Deadline
from planning.domain.request.stopwatch import Stopwatch
from planning.errors import DeadlineExceeded
from planning.parallel.fork_pool import ForkPool
from planning.search.solver import search
from tests.clocks import FakeClock, no_hurry

PORTFOLIO = ("RRTConnect", "PRM", "RRTConnect", "KPIECE1")


class Watched:
    """A pool that records its tasks, and may call a function in the child before the work."""

    def __init__(self, processes=3, before=lambda _: None):
        self._pool = ForkPool(processes)
        self._before = before
        self.made: list[int] = []

    def each(self, work, count, deadline):
        def done(k):
            self._before(k)
            return work(k)

        for k, outcome in self._pool.each(done, count, deadline):
            self.made.append(k)
            yield k, outcome


@pytest.fixture(autouse=True)
def _alone(monkeypatch):
    """Count no threads but this one: those that other tests left idle are no reason not to fork."""
    monkeypatch.setattr(threading, "active_count", lambda: 1)


@pytest.fixture
def long():
    """A deadline by whose clock every attempt takes long enough for the pool."""
    return Deadline.after(1e9, FakeClock(step=1.0))


@pytest.mark.parametrize(
    ("seed", "options"),
    [
        (0, {"attempts": 5}),
        (3, {"attempts": 4, "objective": "duration"}),
        (1, {"planner": PORTFOLIO}),
        (3, {"planner": PORTFOLIO, "attempts": 6, "keep_graph": True}),
    ],
)
def test_side_by_side_is_one_after_another(plane, wall, long, crossing, seed, options):
    task, pool = crossing(seed, **options), Watched()
    serial = search(*plane, wall, task, no_hurry())
    parallel = search(*plane, wall, replace(task, pool=pool), long)
    assert sorted(pool.made) == list(range(task.options.num_attempts - 1))
    assert parallel.path.waypoints.tobytes() == serial.path.waypoints.tobytes()
    assert parallel == serial


def test_stages_of_attempts_in_other_processes_are_timed(plane, wall, long, crossing):
    watch, pool = Stopwatch(long.clock), Watched()
    task = replace(crossing(0, attempts=5, num_states=300), pool=pool)
    search(*plane, wall, task, long, watch)
    assert len(pool.made) == 4
    seconds = watch.seconds
    parts = sum(seconds[name] for name in ("setup", "solve", "shortcut", "interpolate"))
    attempts = sum(seconds[f"attempt_{i}"] for i in range(1, 6))
    assert 0.5 * attempts < parts <= attempts + seconds["setup"]


def test_rounds_of_those_that_fail_are_the_same(plane, make_oracle, soon, long, crossing):
    """If no planner has a path in the first round, the next has more states, in parallel or not."""
    oracle = make_oracle(lambda qs: ~((abs(qs[:, 0]) < 0.1) & (qs[:, 1] < 0.95)))
    task = crossing(planner=("RRT", "PRM", "RRT"), seed=1, resolution=0.0005)
    pool = Watched()
    parallel = search(*plane, oracle, replace(task, pool=pool), long)
    assert len(pool.made) > 2
    assert parallel == search(*plane, oracle, task, soon)


def test_better_paths_are_reported_in_the_same_order(plane, wall, long, crossing):
    def reports_with(pool):
        reports = []
        task = replace(crossing(2, attempts=6), on_best=reports.append, pool=pool)
        search(*plane, wall, task, long)
        return reports

    assert reports_with(Watched()) == reports_with(None) != []


@pytest.mark.parametrize("victims", [{0}, {1, 2}, {0, 1, 2, 3}])
def test_killed_children_do_not_change_the_result(plane, wall, soon, long, crossing, victims):
    task = crossing(2, attempts=5)
    pool = Watched(before=lambda k: k in victims and os.kill(os.getpid(), signal.SIGKILL))
    killed = search(*plane, wall, replace(task, pool=pool), long)
    assert not victims & set(pool.made)
    assert killed == search(*plane, wall, task, soon)


def test_a_cancel_returns_the_best_of_the_completed_attempts(plane, wall, crossing):
    reports = []
    task = crossing(2, attempts=50, on_cancel="best")
    deadline = Deadline.after(1e9, FakeClock(step=1.0), lambda: bool(reports))
    found = search(*plane, wall, replace(task, on_best=reports.append, pool=Watched()), deadline)
    assert found.report.was_canceled
    assert 1 <= found.report.solved < 50


def test_attempts_that_run_out_of_time_fail_as_a_single_one_does(plane, closed, crossing):
    """The first one exceeds its own budget, the others the deadline."""
    task = replace(crossing(attempts=4, solve_time=2_000.0), pool=Watched())
    with pytest.raises(DeadlineExceeded) as caught:
        search(*plane, closed, task, Deadline.after(3_000.0, FakeClock(step=1.0)))
    assert caught.value.evidence["attempts"] == 2


def test_quick_attempts_do_not_go_to_the_pool(plane, wall, soon, crossing):
    pool = Watched()
    found = search(*plane, wall, replace(crossing(2, attempts=3), pool=pool), soon)
    assert found.report.attempts == 3
    assert not pool.made


@pytest.mark.parametrize("is_late", [False, True])
def test_a_deadline_that_cuts_a_child_is_recorded_here(plane, wall, crossing, is_late):
    """In the children time flies, so that there is none for shortcuts."""
    clock, cuts = FakeClock(step=1.0), []
    deadline = Deadline.after(1e9, clock).with_on_expiry(lambda: cuts.append(1))

    def fly(_):
        clock.step = 1e6 if is_late else 1.0

    task, pool = crossing(0, attempts=3, shortcut_time=1e6), Watched(before=fly)
    search(*plane, wall, replace(task, pool=pool), deadline)
    assert pool.made
    assert bool(cuts) == is_late
