"""At most one job moves a robot, and none enters a scene unseen, however many servers are asked."""

import threading
from functools import partial

import pytest

from planning.errors import Canceled
from service.jobs.errors import IdempotencyConflict, Overtaken
from service.jobs.job import JobSpec
from service.jobs.store.drafts import draft
from service.jobs.store.job_store import JobStore
from service.jobs.store.release import release

NUM_SERVERS = 6


def execution(**fields):
    return JobSpec("execution", "m:f", {}, **{"scene": "here", "robots": ("a",), **fields})


def check_one_at_a_time(engines):
    """Check it with a store of its own on each of these engines, which are of one database."""
    stores = [JobStore(engine) for engine in engines]
    stores[0].open()
    first, others = stores[0], stores[1:]
    for number, state in enumerate(("queued", "running", "queued again")):
        assert first.entries("execution", "here").number == number
        won = at_once(stores, [execution(follows=number)] * len(stores))
        assert len(won) == 1
        advance(first, won[0].id, state)
        for store in stores:
            for follows in (number, number + 1, None):
                with pytest.raises(Overtaken):
                    store.insert(execution(follows=follows, robots=("b", "a")))
        elsewhere = others[-1].insert(execution(scene=f"there {state}", follows=0))[0]
        assert [job.id for job in first.page("execution", limit=2)] == [elsewhere.id, won[0].id]
        first.cancel(won[0].id, Canceled("over"))
        # One that began and ended since a request looked has moved the robot.
        with pytest.raises(Overtaken):
            others[-1].insert(execution(follows=number))
    check_robots(stores)
    check_line(stores)
    check_keys(stores)


def check_robots(stores):
    """Check that robots are moved at once, each by one; those of a request are proven together."""
    robots = [("a",), ("b",), ("a", "b"), ("c",), ("b", "c"), ("a", "c")]
    specs = [execution(scene="both", robots=each) for each in robots]
    # None has seen the others: one enters.
    assert len(at_once(stores, [execution(scene="seen", robots=r, follows=0) for r in robots])) == 1
    won = at_once(stores, specs)
    moved = [
        robot for entry in stores[0].entries("execution", "both").open for robot in entry.robots
    ]
    assert len(moved) == len(set(moved)) >= 2
    for job in won:
        stores[0].cancel(job.id, Canceled("over"))
    assert not stores[-1].entries("execution", "both").open


def check_line(stores):
    """Check that what waits is run once, in its order, and only once its robots are free."""
    first, *others = stores
    moves = first.insert(execution(scene="line", robots=("a", "b")))[0]
    waits = partial(execution, scene="line", waits=True)
    jobs = [first.insert(waits(robots=robots))[0] for robots in (("a",), ("b", "c"), ("a", "c"))]
    one, two, three = (job.id for job in jobs)
    assert [job.id for job in others[0].waiting_for_robots()] == [one, two, three]
    assert {one, two, three}.isdisjoint(job.id for job in first.unfinished())
    counted = []
    last = first.insert_drafts([draft(waits(robots=("z",)))], counted.append)[0][0]
    assert counted == [first.counts()["execution", "queued"] - 1]  # they fill the queue
    first.cancel_queued(last.id, Canceled("over"))
    with pytest.raises(Overtaken):  # it is behind those that wait
        others[0].insert(execution(scene="line", robots=("c",)))
    with pytest.raises(Overtaken):
        release(first, one, execution(scene="line"))
    first.start(moves.id)
    first.cancel(moves.id, Canceled("over"))
    with pytest.raises(Overtaken):  # two others are before it
        release(first, three, execution(scene="line"))
    number = first.entries("execution", "line").number
    asked = execution(scene="line", follows=number)
    done = run_at_once([partial(release, store, one, asked) for store in stores])
    assert [job.id for job in done if job is not None] == [one]
    with pytest.raises(Overtaken):  # it was proven beside less than moves by now
        release(first, two, asked)
    assert release(first, two, execution(scene="line", follows=number + 1)).id == two
    assert {one, two} <= {job.id for job in others[0].unfinished()}
    for job in (one, two):
        first.start(job)
        first.cancel(job, Canceled("over"))
    first.request_cancel(three)
    first.cancel_queued(three, Canceled("over"))
    assert release(first, three, execution(scene="line")) is None
    assert first.waiting_for_robots() == []


def check_keys(stores):
    """Check that requests of one key are one job, and that the key comes before the scene."""
    named = execution(follows=3, key="k", request_digest="1")
    won = at_once(stores, [named] * len(stores))
    assert len(won) == 1
    for store in stores:
        assert store.insert(named) == (won[0], False)
        with pytest.raises(IdempotencyConflict):
            store.insert(execution(key="k", request_digest="2"))


def advance(store, identifier, state):
    if state != "queued":
        store.start(identifier)
    if state == "queued again":
        store.requeue(identifier, "its process died")


def at_once(stores, specs):
    """The new jobs that came of one request to each server, all of them at once."""
    found = run_at_once([
        partial(store.insert, spec) for store, spec in zip(stores, specs, strict=True)
    ])
    return [job for job, is_new in found if is_new]


def run_at_once(calls):
    """What calls at once have returned, but for those that were overtaken."""
    made, gate = [], threading.Barrier(len(calls))

    def ask(call):
        gate.wait()
        try:
            made.append(call())
        except Overtaken:
            return

    threads = [threading.Thread(target=ask, args=(call,)) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return made
