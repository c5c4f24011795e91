"""How JobService reads the jobs that there are."""

import asyncio

import pytest

from planning.errors import Canceled
from service.errors import RobotBusy
from service.executions.position import require_at_rest
from service.jobs.job import JobSpec
from service.jobs.service import JobService
from service.jobs.store.database import open_engine
from service.jobs.store.job_store import JobStore

MOVING = {
    "library": {"model_roots": [], "allow_paths": False},
    "scene": {"digest": "d", "document": "file"},
    "request": {"plan": "pln_1"},
    "scene_id": "here",
    "group": "arm",
    "speed": 1.0,
}


class CountingStore(JobStore):
    """Counts the jobs that it has read from the database."""

    num_read = 0
    begins = ""  # a job that begins once something was read

    def page(self, *args, **kwargs):
        found = super().page(*args, **kwargs)
        self.num_read += len(found)
        if self.begins:
            self.start(self.begins)
            self.begins = ""
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
def test_only_the_last_execution_is_read_to_find_what_moves(jobs, store, state):
    spec = JobSpec("execution", "", MOVING, scene="here")
    assert asyncio.run(require_at_rest(jobs, "here")) == 0
    for _ in range(30):
        store.cancel(store.insert(spec)[0].id, Canceled("over"))
    last = store.page("execution", limit=1)[0].sequence
    store.num_read = 0
    assert asyncio.run(require_at_rest(jobs, "here")) == last
    moves = store.insert(spec)[0].id
    if state == "running":
        store.start(moves)
    with pytest.raises(RobotBusy, match=moves):
        asyncio.run(require_at_rest(jobs, "here"))
    assert store.num_read == 2
    assert asyncio.run(require_at_rest(jobs, "elsewhere")) == 0


def test_what_begins_to_move_while_it_is_looked_for_is_found(jobs, store):
    store.begins = store.insert(JobSpec("execution", "", MOVING, scene="here"))[0].id
    with pytest.raises(RobotBusy, match=store.begins):
        asyncio.run(require_at_rest(jobs, "here"))
