"""A dispatcher on a real database with real processes."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from sqlalchemy import text

from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.observer import Observer
from service.jobs.dispatch.scheduling.queue import JobQueue, Share
from service.jobs.dispatch.scheduling.worker_pool import WorkerPool
from service.jobs.job import JobSpec
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.worker.thread_worker import ThreadWorker
from tests.service.jobs import fake_tasks
from tests.service.jobs.databases import FullDisk
from tests.service.jobs.postgres import cluster
from tests.service.jobs.remote.machines import Site, end_clusters, plain_terms
from tests.service.jobs.remote.machines import workers as workers_on

TASKS = fake_tasks.__name__
WARM_UP = "fake.warm"
# What ends within it ends [s]; it is for what hangs, whatever the machine does besides.
GUARD = 120.0


def spec(task: str, /, **options: object) -> JobSpec:
    return JobSpec(**{"queue": "plan", "task": f"fake.{task}", "payload": {}, **options})


@pytest.fixture(scope="session", autouse=True)
def clusters():
    """End the clusters of this process with it."""
    yield
    end_clusters()


@pytest.fixture(scope="module")
def server():
    """A PostgreSQL of its own for a module of tests."""
    with cluster() as made:
        yield made


@pytest.fixture
def url(server):
    """Of a database without tables."""
    engine = open_engine(server.url)
    with engine.begin() as connection:
        connection.execute(text("DROP SCHEMA public CASCADE"))
        connection.execute(text("CREATE SCHEMA public"))
    engine.dispose()
    return server.url


@asynccontextmanager
async def running(  # noqa: PLR0913  (what a test may vary)
    folder: Path,
    *,
    workers: int = 1,
    inline: bool = False,
    max_waiting: int = 100,
    cancel_grace: float = 0.25,
    disks: list[FullDisk] | None = None,
    version: str = "1",
    share: Share | None = None,
    site: Site | None = None,
    observer: Observer | None = None,
) -> AsyncIterator[tuple[Dispatcher, JobStore]]:
    """Run a dispatcher on the database in a folder; `disks` gets the disk that it is on.

    It is on the database and the machines of `site`, if there is one, with so many workers on each.
    """
    at = site or Site()
    engine = open_engine(at.url or f"sqlite:///{folder / 'jobs.sqlite'}")
    if disks is not None:
        disks.append(FullDisk(engine))
    store = JobStore(engine, {"tests": version})
    threads = [ThreadWorker(is_exclusive=False) for _ in range(workers)]
    made = workers_on(at.kind, [TASKS], plain_terms(workers), at.hosts, at.machines)
    pool = WorkerPool(threads if inline else made)
    queues = {"plan": JobQueue("plan", pool, max_waiting, cancel_grace, share=share)}
    dispatcher = Dispatcher(store, DispatcherLock(engine), queues, observer=observer)
    await dispatcher.start(WARM_UP)
    try:
        yield dispatcher, store
    finally:
        await dispatcher.stop()
        engine.dispose()
