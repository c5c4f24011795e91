"""What a job costs: few statements, none of them in the event loop, and no waiting for a start."""

import asyncio
from contextlib import asynccontextmanager

import pytest
from sqlalchemy import event

from planning.errors import Canceled
from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.errors import DatabaseUnavailable
from service.jobs.states import JobState
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import AskedFromLoop, is_in_loop, keep_off_loops, open_engine
from service.jobs.worker.thread_worker import ThreadWorker
from tests.service.jobs.conftest import GUARD, spec
from tests.service.jobs.databases import locked
from tests.service.jobs.test_stopping import eventually


@asynccontextmanager
async def serving(folder, told=None, timeouts=None):
    """A dispatcher of a database that loops may not ask; `told` gets its statements."""
    engine = open_engine(f"sqlite:///{folder / 'jobs.sqlite'}")
    keep_off_loops(engine)
    if told is not None:
        event.listen(engine, "before_cursor_execute", lambda *said: told.append(said[2]))
    store = JobStore(engine)
    queues = {"plan": JobQueue("plan", [ThreadWorker(is_exclusive=False)], 100)}
    dispatcher = Dispatcher(store, DispatcherLock(engine), queues, timeouts=timeouts)
    await dispatcher.start()
    try:
        yield dispatcher, store
    finally:
        await dispatcher.stop()
        await asyncio.to_thread(engine.dispose)


def test_a_job_and_the_wait_for_it_are_a_dozen_statements_and_read_nothing(tmp_path):
    async def story():
        told = []
        async with serving(tmp_path, told) as (dispatcher, store):
            await dispatcher.wait_text((await dispatcher.submit(spec("warm"))).id, GUARD)
            told.clear()
            for _ in range(5):
                job = await dispatcher.submit(spec("warm"))
                ended = await dispatcher.wait_text(job.id, GUARD)
                assert ended.summary.state is JobState.SUCCEEDED
            written = [said for said in told if said.startswith(("INSERT", "UPDATE", "DELETE"))]
            assert len(written) <= 5 * 11
            assert len([said for said in told if "job_owner" in said]) <= 5 * 3
            read = [said for said in told if said.startswith("SELECT")]
            assert {said.split()[3] for said in read} <= {"job_owner"}
            assert len(told) <= 5 * 18
            assert await asyncio.to_thread(store.text, job.id) == ended

    asyncio.run(story())


@pytest.mark.parametrize("task", ["refuse", "echo", "leave"])
def test_what_is_waited_for_is_what_is_recorded(tmp_path, task):
    async def story():
        async with serving(tmp_path) as (dispatcher, store):
            job = await dispatcher.submit(spec(task, payload={"a": [1.5, None]}, scene="s"))
            ended = await dispatcher.wait_text(job.id, GUARD)
            assert ended.summary.state.is_final
            assert await asyncio.to_thread(store.text, job.id) == ended
            again = await dispatcher.submit(spec(task, payload={"a": [1.5, None]}, scene="s"))
            whole = await dispatcher.wait(again.id, GUARD)
            assert await asyncio.to_thread(store.get, again.id) == whole
            # Somebody who comes later reads the same.
            assert await dispatcher.wait_text(job.id, GUARD) == ended

    asyncio.run(story())


def test_a_loop_that_asks_a_database_is_told_so(tmp_path):
    async def story():
        async with serving(tmp_path) as (_, store):
            assert is_in_loop()
            with pytest.raises(AskedFromLoop):
                store.counts()
            assert await asyncio.to_thread(store.counts) == {}

    asyncio.run(story())
    assert not is_in_loop()


def test_what_may_run_twice_begins_before_its_start_is_written(tmp_path):
    """And what may run but once waits for that."""

    async def story():
        async with serving(tmp_path) as (dispatcher, store):
            gate, mark = tmp_path / "gate", tmp_path / "mark"
            first = await dispatcher.submit(spec("wait_for_file", payload={"file": str(gate)}))
            twice = await dispatcher.submit(spec("touch", payload={"file": str(mark)}))
            once = spec("touch", payload={"file": str(tmp_path / "once")}, max_attempts=1)
            once = await dispatcher.submit(once)
            await asyncio.to_thread(until_running, store, first.id)
            with locked(tmp_path / "jobs.sqlite"):
                gate.touch()
                await eventually(mark.exists)
                assert (await asyncio.to_thread(store.get, twice.id)).state is JobState.QUEUED
                run = dispatcher.attempt_of(once.id)
                await eventually(lambda: run.has_begun)
                for _ in range(20):
                    await asyncio.sleep(0)
                assert not (tmp_path / "once").exists()
            for job in (first, twice, once):
                ended = await dispatcher.wait_text(job.id, GUARD)
                assert ended.summary.state is JobState.SUCCEEDED
                numbers = [told.number for told in await asyncio.to_thread(store.events, job.id)]
                assert numbers == list(range(1, len(numbers) + 1))
            assert (tmp_path / "mark").read_text().count("\n") == 1

    asyncio.run(story())


def until_running(store, identifier):
    while store.get(identifier).state is not JobState.RUNNING:
        pass


def test_a_run_whose_start_is_not_wanted_is_ended(tmp_path):
    """Another hand has ended the job while it was queued: nothing of the run is recorded."""

    async def story():
        async with serving(tmp_path) as (dispatcher, store):
            gate = tmp_path / "gate"
            await dispatcher.submit(spec("wait_for_file", payload={"file": str(gate)}))
            job = await dispatcher.submit(spec("spin"))
            run = dispatcher.attempt_of(job.id)
            assert await asyncio.to_thread(store.cancel_queued, job.id, Canceled("elsewhere"))
            gate.touch()
            await asyncio.wait_for(run.concluded.wait(), GUARD)
            ended = await asyncio.to_thread(store.get, job.id)
            assert (ended.state, ended.attempts) == (JobState.CANCELED, 0)
            told = await asyncio.to_thread(store.events, job.id)
            assert [one.type for one in told] == ["queued", "finished"]
            last = await dispatcher.submit(spec("warm"))
            assert (await dispatcher.wait(last.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


def test_a_job_that_cannot_be_recorded_is_refused_for_certain(tmp_path):
    async def story():
        async with serving(tmp_path, timeouts=DatabaseTimeouts(record=0.05)) as (dispatcher, store):
            with locked(tmp_path / "jobs.sqlite"), pytest.raises(DatabaseUnavailable) as refusal:
                await dispatcher.submit(spec("warm", key="k"))
            assert refusal.value.evidence["retry_after"] >= 1
            later = await dispatcher.submit(spec("warm"))
            assert (await dispatcher.wait(later.id, GUARD)).state is JobState.SUCCEEDED
            assert [job.id for job in await asyncio.to_thread(store.page, "plan")] == [later.id]

    asyncio.run(story())
