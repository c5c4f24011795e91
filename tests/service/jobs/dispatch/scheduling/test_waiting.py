"""Whose turn it is: what ages is not left behind, clients take turns, and no worker idles."""

import itertools
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.dispatch.scheduling.waiting import (
    AGEING,
    RANGE,
    Place,
    QueueEntry,
    WaitingEntries,
)
from service.jobs.job import Priority
from tests.profiles import num_cases
from tests.service.jobs.dispatch.queues import free, names, queue_of, wait

LEVELS = [priority.level for priority in Priority]
NONE = float("inf")


def entry(name, client, priority=0, since=0.0, order=0):
    return QueueEntry(name, Place(since, order), lambda _: None, None, priority, client)


def served(queue, num_runs, now=0.0):
    """Who gets the one worker of a queue, one after another."""
    found = []
    for _ in range(num_runs):
        [(got, worker)] = queue.assign(now).pairs
        found.append(got.name)
        free(queue, worker, 1.0, now)
    return found


def test_priorities_are_levels_about_normal():
    assert [(priority.value, priority.level) for priority in Priority] == [
        ("low", -1), ("normal", 0), ("high", 1)
    ]  # fmt: skip


def test_clients_take_turns_however_much_they_request():
    queue = queue_of(1)
    for i in range(4):
        wait(queue, f"a{i}", client="a")
    for name in ("b0", "c0", "b1"):
        wait(queue, name, client=name[0])
    assert served(queue, 7) == ["a0", "b0", "c0", "a1", "b1", "a2", "a3"]


def test_who_comes_anew_is_behind_who_waits():
    queue = queue_of(1)
    for i in range(3):
        wait(queue, f"a{i}", client="a")
    assert served(queue, 1) == ["a0"]
    wait(queue, "b0", client="b")
    assert served(queue, 3) == ["a1", "b0", "a2"]


def test_a_priority_goes_before_the_turn_of_a_client():
    queue = queue_of(1)
    for i in range(2):
        wait(queue, f"a{i}", client="a", priority=Priority.HIGH.level)
        wait(queue, f"b{i}", client="b")
    assert served(queue, 4) == ["a0", "a1", "b0", "b1"]


@pytest.mark.parametrize("client", ["a", "b"])
def test_what_is_low_overtakes_what_is_high_once_it_is_old(client):
    queue = queue_of(1)
    wait(queue, "old", client=client, priority=Priority.LOW.level)
    late = RANGE * AGEING
    wait(queue, "before", client="a", priority=Priority.HIGH.level, since=late - 1.0)
    assert served(queue, 1, late - 1.0) == ["before"]
    wait(queue, "after", client="a", priority=Priority.HIGH.level, since=late)
    assert served(queue, 2, late) == ["old", "after"]


def test_a_long_line_of_what_is_low_does_not_become_urgent_as_a_whole():
    """One of it goes first, and then the next one waits as long."""
    queue = queue_of(1, max_waiting=100)
    for i in range(5):
        wait(queue, f"low{i}", priority=Priority.LOW.level)
    late = RANGE * AGEING
    for i in range(5):
        wait(queue, f"high{i}", priority=Priority.HIGH.level, since=late)
    assert served(queue, 3, late) == ["low0", "high0", "high1"]
    assert served(queue, 2, 2 * late) == ["low1", "high2"]


def test_what_comes_again_has_the_age_that_it_had():
    queue = queue_of(1)
    wait(queue, "low", priority=Priority.LOW.level)
    [(again, worker)] = queue.assign(0.0).pairs
    late = RANGE * AGEING
    wait(queue, "high", priority=Priority.HIGH.level, since=late)
    queue.add(again)
    free(queue, worker, 1.0, late)
    assert served(queue, 2, late) == ["low", "high"]


requests = st.tuples(st.sampled_from("abcd"), st.sampled_from(LEVELS))
steps = st.lists(st.one_of(requests, st.floats(0.0, 2 * AGEING), st.none()), max_size=120)


class Line:
    """What waits, with what must hold of it, in the words of the module."""

    def __init__(self):
        self.waiting = WaitingEntries()
        self.entries = {}
        self.served_at = {}
        self.passed = Counter()
        self.bounds = {}
        self.orders = itertools.count()

    def add(self, client, priority, now):
        order = next(self.orders)
        self.entries[str(order)] = entry(str(order), client, priority, now, order)
        self.waiting.add(self.entries[str(order)])

    def first_of_lines(self):
        lines = {}
        for each in sorted(self.entries.values(), key=lambda other: other.place.order):
            lines.setdefault((each.client, each.priority), each)
        return lines

    def bound(self, each):
        """How many go before it at most once its line is ripe: see `waiting`."""
        others = [
            other
            for other in self.entries.values()
            if other.client == each.client and other.place.order < each.place.order
        ]
        return (len(others) + 1) * len({other.client for other in self.entries.values()}) - 1

    def serve(self, now):
        """Let the next one go; return it, and whether each ripe entry was passed too often."""
        for key, first in self.first_of_lines().items():
            age = now - max(first.place.since, self.served_at.get(key, -NONE))
            if age >= RANGE * AGEING:
                self.bounds.setdefault(first.name, self.bound(first))
        got = next(self.waiting.in_order(now))
        self.waiting.take(got, now)
        del self.entries[got.name]
        self.served_at[got.client, got.priority] = now
        self.bounds.pop(got.name, None)
        for name in self.bounds:
            self.passed[name] += 1
            assert self.passed[name] <= self.bounds[name]
        return got


@given(steps, st.integers(0, 40))
def test_what_is_ripe_is_passed_no_more_often_than_is_said(workload, num_ahead):
    """Whatever comes, whenever: against clients that come without end as well."""
    line, now = Line(), 0.0
    for _ in range(num_ahead):
        line.add("a", 1, now)
    for i, step in enumerate(workload):
        if isinstance(step, tuple):
            line.add(*step, now)
            line.add(f"passer-by {i}", 1, now)
        elif isinstance(step, float):
            now += step
        elif line.entries:
            line.serve(now)
    while line.entries:  # nothing is ever lost
        now += 1.0
        line.serve(now)
    assert len(line.waiting) == 0


@pytest.mark.parametrize("num_before", [0, 1, 3])
def test_under_a_flood_of_what_is_high_what_is_low_is_served_within_its_bound(num_before):
    """One worker, runs of a second each, and in each second more comes than is done."""
    queue = queue_of(1, max_waiting=10**6)
    for i in range(num_before + 1):
        wait(queue, f"low{i}", client="quiet", priority=Priority.LOW.level)
    for now in itertools.count(0.0):
        for client in ("x", "y"):
            wait(queue, f"{client}{now}", client=client, priority=1, since=now)
        if served(queue, 1, now) == [f"low{num_before}"]:
            break
    assert now <= (num_before + 1) * (RANGE * AGEING + 3)


@given(st.lists(st.sampled_from("abc"), max_size=60), st.sampled_from(LEVELS))
def test_clients_that_always_have_something_waiting_are_served_alike(arrivals, level):
    """Over any stretch in which two have, neither has one run more than the other plus one."""
    waiting, order = WaitingEntries(), itertools.count()
    for client in "aabb":  # two that never run out, among others that come and go
        waiting.add(entry(f"{next(order)}", client, level, 0.0, next(order)))
    gained = [Counter()]
    for client in arrivals:
        waiting.add(entry(f"{next(order)}", client, level, 0.0, next(order)))
        got = next(waiting.in_order(0.0))
        waiting.take(got, 0.0)
        gained.append(gained[-1] + Counter(got.client))
        if got.client in "ab":
            waiting.add(entry(f"{next(order)}", got.client, level, 0.0, next(order)))
    for begin, end in itertools.combinations(gained, 2):
        assert abs((end["a"] - begin["a"]) - (end["b"] - begin["b"])) <= 1


@given(st.lists(st.tuples(requests, st.floats(0.0, 100.0)), max_size=20), st.data())
def test_what_is_taken_at_once_is_what_is_taken_one_after_another(workload, data):
    at_once, one_by_one = WaitingEntries(), WaitingEntries()
    whens = sorted(since for _, since in workload)
    for i, ((client, priority), _) in enumerate(workload):
        for waiting in (at_once, one_by_one):
            waiting.add(entry(str(i), client, priority, whens[i], i))
    count = data.draw(st.integers(0, len(workload)))
    taken = []
    for each in itertools.islice(at_once.in_order(100.0), count):
        taken.append(each.name)
        at_once.take(each, 100.0)
    for name in taken:
        each = next(one_by_one.in_order(100.0))
        assert each.name == name
        one_by_one.take(each, 100.0)


@given(
    st.lists(
        st.tuples(st.sampled_from(["come", "tick", "free"]), st.integers(0, 3), requests),
        max_size=num_cases(60, 120),
    )
)
def test_no_worker_idles_but_for_a_warm_one_and_never_beyond_its_bound(steps):
    """Work is conserved, and the wait for a warm worker ends at the time that is told."""
    queue, now, busy = queue_of(3, warm_wait=0.1, max_waiting=10**6), 0.0, []
    came = {}
    for i, (what, key, (client, priority)) in enumerate(steps):
        if what == "come":
            came[str(i)] = now
            wait(queue, str(i), f"k{key}", now, client=client, priority=priority)
        elif what == "tick":
            now += 0.03
        elif busy:
            free(queue, busy.pop(key % len(busy)), 0.1, now)
        decided = queue.assign(now)
        for got, worker in decided.pairs:
            busy.append(worker)
            del came[got.name]
        if queue.pool.has_idle and came:
            assert decided.decide_again == pytest.approx(min(came.values()) + 0.1)
            assert all(now < since + 0.1 for since in came.values())
        else:
            assert not queue.pool.has_idle or not came
        assert queue.num_waiting == len(came)


def test_the_advice_when_to_come_again_is_by_what_ended_in_the_last_minute():
    queue = queue_of(1, max_waiting=1000)
    for i in range(200):
        wait(queue, str(i), since=100.0)
    now = 100.0
    for _ in range(100):  # ten a second
        [(_, worker)] = queue.assign(now).pairs
        now += 0.1
        free(queue, worker, 0.1, now)
    # Half of the hundred that wait are done in five seconds.
    assert queue.retry_after(now) == pytest.approx(5.5, abs=1.0)
    assert queue.retry_after(now + 30.0) == pytest.approx(21, abs=2)
    assert queue.retry_after(now + 61.0) == 60


def test_a_time_in_which_nothing_waited_says_nothing_of_the_throughput():
    queue = queue_of(1, max_waiting=1000)
    wait(queue, "only", since=0.0)
    queue.assign(0.0)
    for i in range(9):
        wait(queue, str(i), since=1000.0)
    assert queue.retry_after(1000.0) == 5  # as if one had just taken a second
    assert names(queue.assign(1000.0)) == []
