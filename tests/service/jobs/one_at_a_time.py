"""At most one execution of a scene is open, however many servers are asked at once."""

import threading

import pytest

from planning.errors import Canceled
from service.jobs.errors import IdempotencyConflict, Overtaken
from service.jobs.job import JobSpec
from service.jobs.store.job_store import JobStore

NUM_SERVERS = 6


def execution(**fields):
    return JobSpec("execution", "m:f", {}, **{"scene": "here", "follows": 0, **fields})


def check_one_at_a_time(engines):
    """Check it with a store of its own on each of these engines, which are of one database."""
    stores = [JobStore(engine) for engine in engines]
    stores[0].open()
    first, others = stores[0], stores[1:]
    last = 0
    for state in ("queued", "running", "queued again"):
        won = inserted_at_once(stores, execution(follows=last))
        assert len(won) == 1
        advance(first, won[0].id, state)
        for store in stores:
            with pytest.raises(Overtaken):
                store.insert(execution(follows=last))
            with pytest.raises(Overtaken):
                store.insert(execution(follows=won[0].sequence))
            with pytest.raises(Overtaken):
                store.insert(execution(follows=None))
        elsewhere = others[-1].insert(execution(scene=f"there {state}"))[0]
        assert [job.id for job in first.page("execution", limit=2)] == [elsewhere.id, won[0].id]
        first.cancel(won[0].id, Canceled("over"))
        # One that began and ended since a request looked has moved the robot.
        with pytest.raises(Overtaken):
            others[-1].insert(execution(follows=last))
        last = won[0].sequence
    check_keys(stores, last)


def check_keys(stores, last):
    """Check that requests of one key are one job, and that the key comes before the scene."""
    named = execution(follows=last, key="k", request_digest="1")
    won = inserted_at_once(stores, named)
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


def inserted_at_once(stores, spec):
    """The jobs that came of one request to every server at once."""
    made, gate = [], threading.Barrier(len(stores))

    def ask(store):
        gate.wait()
        try:
            job, is_new = store.insert(spec)
        except Overtaken:
            return
        if is_new:
            made.append(job)

    threads = [threading.Thread(target=ask, args=(store,)) for store in stores]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return made
