"""How JobService reads the jobs that there are."""

import asyncio

import pytest

from planning.errors import Canceled
from service.jobs.job import JobSpec
from service.jobs.service import JobService
from service.jobs.store.entries import Entries, OpenEntry
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine


class CountingStore(JobStore):
    """Counts the jobs that it has read from the database."""

    num_read = 0

    def page(self, *args, **kwargs):
        found = super().page(*args, **kwargs)
        self.num_read += len(found)
        return found


@pytest.fixture
def store(tmp_path):
    engine = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    opened = CountingStore(engine)
    opened.open()
    yield opened
    engine.dispose()


@pytest.fixture
def jobs(store):
    # what reads needs no dispatcher
    return JobService(store, None, prefixes={}, queues=())  # pyright: ignore[reportArgumentType]


async def taken(jobs, count):
    found = []
    async for job in jobs.newest("regions", world_digest="here"):
        found.append(job.id)
        if len(found) == count:
            break
    return found


@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 43])
def test_the_newest_come_first_and_all_of_them(jobs, store, count):
    made = []
    for _ in range(count):
        made.append(store.insert(JobSpec("regions", "", {}, world_digest="here"))[0].id)
        store.insert(JobSpec("regions", "", {}, world_digest="elsewhere"))
    assert asyncio.run(taken(jobs, -1)) == made[::-1]


@pytest.mark.parametrize("wanted", [1, 2, 5])
def test_no_more_are_read_than_were_looked_at_and_as_many_again(jobs, store, wanted):
    for _ in range(30):
        store.insert(JobSpec("regions", "", {}, world_digest="here"))
    assert len(asyncio.run(taken(jobs, wanted))) == wanted
    assert store.num_read < 2 * wanted


@pytest.mark.parametrize("state", ["queued", "running"])
def test_what_moves_robots_is_read_of_open_jobs_alone(jobs, store, state):
    spec = JobSpec("execution", "", {}, scene="here", robots=("arm",))
    for _ in range(3):
        store.cancel(store.insert(spec)[0].id, Canceled("over"))
    store.insert(JobSpec("execution", "", {}, scene="elsewhere", robots=("arm",)))
    assert asyncio.run(jobs.entries("execution", "here")) == Entries(3, [])
    moves = store.insert(spec)[0]
    if state == "running":
        store.start(moves.id)
    found = asyncio.run(jobs.entries("execution", "here"))
    entry = OpenEntry(moves.id, moves.sequence, frozenset({"arm"}), is_waiting=False)
    assert found == Entries(4, [entry])
    assert found.in_the_way({"arm", "other"}) == entry
    assert found.in_the_way({"other"}) is None
