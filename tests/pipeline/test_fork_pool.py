"""Attempts side by side: the bytes of one after another, whoever dies, and nobody left behind."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import planning
from planning.domain.deadline import Deadline
from planning.domain.goal import ConfigurationGoal
from planning.domain.options import RefineOptions, SearchOptions
from planning.domain.problem import PlanningProblem
from planning.errors import Canceled, DeadlineExceeded, NoPathFound
from planning.fork_pool import ForkPool
from planning.shared_cores import SharedCores
from tests.conftest import bundled_world

PORTFOLIO = ("RRTConnect", "PRM", "RRTConnect", "KPIECE1")


class Watched:
    """A pool that counts what it did, and may do something in the child before the work."""

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


def children():
    return set(Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split())


@pytest.fixture(autouse=True)
def _nobody_is_left():
    assert threading.active_count() == 1, "a pool does nothing where there are threads"
    before = children()
    yield
    assert children() == before


def problem_of(seed, **options):
    return PlanningProblem(
        "body",
        ConfigurationGoal("exit"),
        search=SearchOptions(allowed_planning_time=30.0, **options),
        refine=RefineOptions("none"),
        seed=seed,
    )


def solve(problem, pool=None, is_canceled=lambda: False, on_progress=lambda _: None):
    deadline = Deadline.after(30.0, time.monotonic, is_canceled)
    world = bundled_world("maze_2d")
    return planning.plan(problem, world, deadline=deadline, pool=pool, on_progress=on_progress)


@pytest.mark.parametrize(
    "options",
    [{"attempts": 5}, {"attempts": 2, "objective": "duration"}, {"planner": PORTFOLIO}],
)
@pytest.mark.parametrize("seed", [0, 3])
def test_side_by_side_is_one_after_another(seed, options):
    pool = Watched()
    problem = problem_of(seed, keep_graph=True, **options)
    serial, parallel = solve(problem), solve(problem, pool)
    assert set(range(problem.search.num_attempts)) <= set(pool.made)
    assert parallel.digest == serial.digest
    assert parallel.stages == serial.stages
    assert parallel.graph == serial.graph
    assert parallel.timings.keys() >= {f"attempt_{k + 1}" for k in range(2)}


def test_events_come_in_the_same_order():
    def told(pool):
        lengths = []
        solve(problem_of(1, attempts=6), pool, on_progress=lengths.append)
        return [progress.best_length for progress in lengths if progress.best_length]

    assert told(Watched()) == told(None) != []


@pytest.mark.parametrize("victims", [{0}, {1, 2}, {0, 1, 2, 3, 4}])
def test_whoever_is_killed_the_answer_is_the_same(victims):
    problem = problem_of(2, attempts=5)
    pool = Watched(before=lambda k: k in victims and os.kill(os.getpid(), signal.SIGKILL))
    killed = solve(problem, pool)
    assert not victims & set(pool.made)
    serial = solve(problem)
    assert killed.digest == serial.digest
    assert killed.stages == serial.stages


def forever(_):
    while True:
        threading.Event().wait(1.0)


def test_a_cancel_ends_all_at_once():
    began = time.monotonic()
    deadline = Deadline.after(60.0, time.monotonic, lambda: time.monotonic() > began + 0.2)
    with pytest.raises(Canceled), closing(ForkPool(3).each(forever, 9, deadline)) as arrivals:
        list(arrivals)
    assert time.monotonic() - began < 1.2


def test_who_ignores_the_deadline_is_ended():
    began = time.monotonic()
    assert list(ForkPool(2).each(forever, 4, Deadline.after(0.1, time.monotonic))) == []
    assert time.monotonic() - began < 2.0


def test_a_cancel_leaves_the_best_of_what_has_ended():
    told = []
    found = solve(
        problem_of(2, attempts=60, on_cancel="best"),
        Watched(),
        is_canceled=lambda: any(progress.best_length for progress in told),
        on_progress=told.append,
    )
    assert found.certificate.proven
    assert found.stages.search.was_canceled
    assert 1 <= found.stages.search.solved < 60


def test_errors_come_home_and_faults_are_left_to_the_caller():
    def work(k):
        if k == 1:
            message = "nothing"
            raise NoPathFound(message, {"k": k})
        if k == 2:
            return 1 / 0
        return np.full(200_000, k)

    with closing(ForkPool(2).each(work, 5, Deadline.after(20.0, time.monotonic))) as arrivals:
        found = dict(arrivals)
    assert found.keys() >= {0, 1, 3, 4}
    assert 2 not in found
    assert found[1].evidence == {"k": 1}
    assert (found[4] == 4).all()


def test_all_who_run_out_of_time_say_so_as_one_alone_would():
    closed = """
    robots: [{name: body, model: planar_l, positions: [-0.35, -0.3, 0]}]
    objects: [{name: wall, shape: {box: [0.02, 9, 0.2]}, pose: {position: [0, 0, 0]}}]
    configurations: {exit: {group: body, positions: [0.3, -0.3, 0]}}
    """
    world = planning.load_world(planning.parse_scene(closed))
    with pytest.raises(DeadlineExceeded) as caught:
        planning.plan(
            problem_of(0, attempts=4),
            world,
            deadline=Deadline.after(0.6, time.monotonic),
            pool=ForkPool(2),
        )
    assert caught.value.evidence["attempts"] >= 1


def test_one_process_or_one_attempt_forks_nobody():
    deadline = Deadline.after(9.0, time.monotonic)
    assert list(ForkPool(1).each(forever, 9, deadline)) == []
    assert list(ForkPool(4).each(forever, 1, deadline)) == []


ORPHANS = """
import os, sys, time
from planning.domain.deadline import Deadline
from planning.fork_pool import ForkPool
def work(k):
    os.write(1, f"{os.getpid()}\\n".encode())
    while True: time.sleep(1)
list(ForkPool(2).each(work, 4, Deadline.after(60.0, time.monotonic)))
"""


def test_children_die_with_their_parent():
    with subprocess.Popen([sys.executable, "-c", ORPHANS], stdout=subprocess.PIPE) as parent:
        pids = [int(parent.stdout.readline()) for _ in range(2)]
        parent.kill()
    end = time.monotonic() + 5.0
    while any(is_alive(pid) for pid in pids):
        assert time.monotonic() < end
        threading.Event().wait(0.01)


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_no_core_is_lent_twice_and_none_is_lost(tmp_path):
    here, there = SharedCores(tmp_path, 3), SharedCores(tmp_path, 3)
    with here.lent(2) as mine:
        assert mine == 2
        with there.lent(5) as theirs, here.lent(1) as none:
            assert (theirs, none) == (1, 0)
        with there.lent(0) as nothing:
            assert nothing == 0
    with there.lent(5) as all_of_them:
        assert all_of_them == 3
    blocked = tmp_path / "file"
    blocked.write_text("")
    with SharedCores(blocked, 3).lent(2) as none:
        assert none == 0


def test_a_core_of_a_process_that_was_killed_is_free_again(tmp_path):
    script = f"""
import os, time
from pathlib import Path
from planning.shared_cores import SharedCores
with SharedCores(Path({str(tmp_path)!r}), 2).lent(2) as lent:
    os.write(1, f"{{lent}}\\n".encode())
    time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline() == b"2\n"
        with SharedCores(tmp_path, 2).lent(1) as none:
            assert none == 0
        holder.kill()
    with SharedCores(tmp_path, 2).lent(2) as both:
        assert both == 2
