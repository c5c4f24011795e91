"""Dispatchers that work on one PostgreSQL database, as several servers do."""

from contextlib import asynccontextmanager
from functools import partial

from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import keep_off_loops, open_engine
from service.jobs.worker.process_worker import ProcessWorker
from service.jobs.worker.thread_worker import ThreadWorker
from tests.service.jobs.conftest import GUARD, TASKS, WARM_UP


class Quick(DatabaseTimeouts):
    """Takes up soon what another has left running."""

    takeover = 0.5


def quick(**options):
    """Timeouts; nothing is found by looks at the table, but what is notified of or left behind."""
    usual = {"period": 0.05, "patience": 0.2, "poll": 10 * GUARD, "record": GUARD, "answer": GUARD}
    return Quick(**usual | options)


@asynccontextmanager
async def serving(url, *, timeouts=None, inline=False, max_waiting=2000, workers=1):
    """A dispatcher and its store, whichever role it has."""
    engine = open_engine(url)
    keep_off_loops(engine)
    store = JobStore(engine)
    thread, process = partial(ThreadWorker, is_exclusive=False), partial(ProcessWorker, [TASKS])
    made = [thread() if inline else process() for _ in range(workers)]
    queues = {"plan": JobQueue("plan", made, max_waiting)}
    dispatcher = Dispatcher(store, DispatcherLock(engine), queues, timeouts=timeouts or quick())
    try:
        await dispatcher.start(WARM_UP)
        try:
            yield dispatcher, store
        finally:
            await dispatcher.stop()
    finally:
        engine.dispose()


@asynccontextmanager
async def two(url, **options):
    """The one that leads, and one that follows."""
    async with serving(url, **options) as (leader, _), serving(url, **options) as (follower, _):
        assert (leader.role, follower.role) == ("leader", "follower")
        yield leader, follower
