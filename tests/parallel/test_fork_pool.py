"""Forked children: they do the work, they die with their parent, and none is left behind."""

import os
import subprocess
import sys
import threading
import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import planning
from planning.domain.goals.goal import ConfigurationGoal
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RefineOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import Canceled, NoPathFound
from planning.parallel.core_leases import CoreLeases
from planning.parallel.fork_pool import ForkPool
from tests.clocks import FakeClock, no_hurry
from tests.conftest import bundled_world

# Against tests that hang [s]; none of them waits for so long.
HANG = 120.0


def children():
    return set(Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split())


@pytest.fixture(autouse=True)
def _no_child_is_left(monkeypatch):
    # Threads that other tests left idle are no reason not to fork.
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    before = children()
    yield
    assert children() == before


class Counted:
    """A pool that notes which pieces came from its children."""

    def __init__(self, pool):
        self.pool, self.numbers = pool, []

    def each(self, work, count, deadline):
        for number, outcome in self.pool.each(work, count, deadline):
            self.numbers.append(number)
            yield number, outcome


def test_a_plan_with_a_pool_is_the_same_plan():
    """The first attempt takes long by this clock, and so the others are handed out."""
    problem = PlanningProblem(
        "body",
        ConfigurationGoal("exit"),
        search=SearchOptions(attempts=3, allowed_planning_time=1e9),
        refine=RefineOptions("none"),
    )
    world, counted = bundled_world("maze_2d"), Counted(ForkPool(2))
    serial, parallel = (
        planning.plan(problem, world, deadline=Deadline.after(1e9, FakeClock(step=0.1)), pool=pool)
        for pool in (None, counted)
    )
    assert sorted(counted.numbers) == [0, 1]
    assert parallel.digest == serial.digest
    assert parallel.stages == serial.stages
    assert parallel.timings.keys() >= {"attempt_1", "attempt_2", "attempt_3"}


def forever(_):
    while True:
        threading.Event().wait(1.0)


@dataclass
class Endless:
    """Work that never ends, and knows which processes have begun it."""

    folder: Path

    def __call__(self, _):
        (self.folder / str(os.getpid())).touch()
        forever(_)

    @property
    def pids(self):
        return [int(file.name) for file in self.folder.iterdir()]


def test_a_cancel_ends_all_that_have_begun(tmp_path):
    work = Endless(tmp_path)
    deadline = Deadline.after(HANG, time.monotonic, lambda: len(work.pids) == 3)
    with pytest.raises(Canceled), closing(ForkPool(3).each(work, 9, deadline)) as arrivals:
        list(arrivals)
    assert len(work.pids) == 3
    assert not any(map(is_alive, work.pids))


def test_a_task_that_ignores_the_deadline_is_ended(tmp_path):
    work = Endless(tmp_path)

    def clock():
        return 100.0 if len(work.pids) == 2 else 0.0

    assert list(ForkPool(2).each(work, 4, Deadline.after(0.1, clock))) == []
    assert not any(map(is_alive, work.pids))


def test_errors_come_home_and_faults_are_left_to_the_caller():
    def work(k):
        if k == 1:
            message = "nothing"
            raise NoPathFound(message, {"k": k})
        if k == 2:
            return 1 / 0
        return np.full(200_000, k)

    with closing(ForkPool(2).each(work, 5, Deadline.after(HANG, time.monotonic))) as arrivals:
        found = dict(arrivals)
    assert found.keys() == {0, 1, 3, 4}
    assert found[1].evidence == {"k": 1}
    assert (found[4] == 4).all()


def test_one_process_or_one_attempt_forks_none():
    deadline = no_hurry()
    assert list(ForkPool(1).each(forever, 9, deadline)) == []
    assert list(ForkPool(4).each(forever, 1, deadline)) == []


def test_a_program_of_several_threads_is_not_forked(monkeypatch):
    monkeypatch.setattr(threading, "active_count", lambda: 2)
    assert list(ForkPool(4).each(forever, 9, no_hurry())) == []


ORPHANS = """
import os, sys, time
from planning.domain.request.deadline import Deadline
from planning.parallel.fork_pool import ForkPool
def work(k):
    os.write(1, f"{os.getpid()}\\n".encode())
    while True: time.sleep(1)
list(ForkPool(2).each(work, 4, Deadline.after(60.0, time.monotonic)))
"""


def test_children_die_with_their_parent():
    with subprocess.Popen([sys.executable, "-c", ORPHANS], stdout=subprocess.PIPE) as parent:
        pids = [int(parent.stdout.readline()) for _ in range(2)]
        parent.kill()
    end = time.monotonic() + HANG
    while any(is_alive(pid) for pid in pids):
        assert time.monotonic() < end
        threading.Event().wait(0.01)


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_no_core_is_lent_twice_and_none_is_lost(tmp_path):
    here, there = CoreLeases(tmp_path, 3), CoreLeases(tmp_path, 3)
    with here.lease(2) as mine:
        assert mine == 2
        with there.lease(5) as theirs, here.lease(1) as none:
            assert (theirs, none) == (1, 0)
        with there.lease(0) as nothing:
            assert nothing == 0
    with there.lease(5) as all_of_them:
        assert all_of_them == 3
    blocked = tmp_path / "file"
    blocked.write_text("")
    with CoreLeases(blocked, 3).lease(2) as none:
        assert none == 0


def test_a_core_of_a_process_that_was_killed_is_free_again(tmp_path):
    script = f"""
import os, time
from pathlib import Path
from planning.parallel.core_leases import CoreLeases
with CoreLeases(Path({str(tmp_path)!r}), 2).lease(2) as lent:
    os.write(1, f"{{lent}}\\n".encode())
    time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline() == b"2\n"
        with CoreLeases(tmp_path, 2).lease(1) as none:
            assert none == 0
        holder.kill()
    with CoreLeases(tmp_path, 2).lease(2) as both:
        assert both == 2
