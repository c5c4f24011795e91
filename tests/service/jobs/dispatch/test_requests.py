"""A job begins while it is written, is told of once it is durable, and is nothing if refused."""

import asyncio
import os
import sqlite3
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from service.jobs.dispatch.attempts import Attempts
from service.jobs.dispatch.conclusion import NoConclusion
from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from service.jobs.dispatch.observer import Observer
from service.jobs.dispatch.requests import JobSubmission
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.dispatch.scheduling.scheduler import Scheduler
from service.jobs.errors import DatabaseUnavailable, IdempotencyConflict
from service.jobs.states import JobState
from service.jobs.store.drafts import draft
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.worker.thread_worker import ThreadWorker
from tests.service.jobs.conftest import GUARD, spec
from tests.service.jobs.databases import locked
from tests.service.jobs.test_job_costs import serving
from tests.service.jobs.test_stopping import eventually


def state_on_disk(folder, identifier):
    """What any other process would read."""
    with sqlite3.connect(folder / "jobs.sqlite") as other:
        found = other.execute("SELECT state FROM jobs WHERE id = ?", (identifier,)).fetchone()
    other.close()
    return None if found is None else found[0]


def watched(store):
    """The transactions of a store from now on: whether each is durable, and flushes."""
    told = []
    transaction, flush = store.transaction, store.flush

    @contextmanager
    def noted(*, is_durable):
        is_outer = store._open_transaction is None
        with transaction(is_durable=is_durable) as connection:
            yield connection
        if is_outer:
            told.append(is_durable)

    def flushed():
        flush()
        told.append("flush")

    store.transaction, store.flush = noted, flushed
    return told


def test_what_may_run_twice_begins_before_it_is_written(tmp_path):
    """And what may run but once does not."""

    async def story():
        async with serving(tmp_path) as (dispatcher, store):
            files = [tmp_path / "twice", tmp_path / "once"]
            wanted = [spec("touch", payload={"file": str(file)}) for file in files]
            once = spec("touch", payload={"file": str(files[1])}, max_attempts=1)
            with locked(tmp_path / "jobs.sqlite"):
                asked = [asyncio.create_task(dispatcher.submit(x)) for x in (wanted[0], once)]
                await eventually(files[0].exists)
                assert not any(task.done() for task in asked)
                assert not files[1].exists()
            for task, file in zip(asked, files, strict=True):
                job = await task
                ended = await dispatcher.wait_text(job.id, GUARD)
                assert ended.summary.state is JobState.SUCCEEDED
                assert ended == await asyncio.to_thread(store.text, job.id)
                assert ended.summary.sequence == job.sequence > 0
                told = await asyncio.to_thread(store.events, job.id)
                assert [one.number for one in told] == list(range(1, len(told) + 1))
                assert [told[0].type, told[1].type] == ["queued", "started"]
                assert file.read_text().count("\n") == 1

    asyncio.run(story())


@pytest.mark.parametrize("task", ["spin", "touch"])
def test_what_is_refused_ends_and_leaves_no_trace(tmp_path, task):
    """Whether it runs then, or has run."""

    async def story():
        async with serving(tmp_path, timeouts=DatabaseTimeouts(record=0.2)) as (dispatcher, store):
            mark = tmp_path / "mark"
            with locked(tmp_path / "jobs.sqlite"):
                asked = asyncio.create_task(
                    dispatcher.submit(spec(task, payload={"file": str(mark)}))
                )
                await eventually(lambda: bool(dispatcher._attempts))
                [run] = dispatcher._attempts.values()
                if task == "touch":
                    await eventually(mark.exists)
                with pytest.raises(DatabaseUnavailable):
                    await asked
            await asyncio.wait_for(run.concluded.wait(), GUARD)
            assert dispatcher.attempt_of(run.job.id) is None
            later = await dispatcher.submit(spec("warm"))
            assert (await dispatcher.wait(later.id, GUARD)).state is JobState.SUCCEEDED
            assert [job.id for job in await asyncio.to_thread(store.page, "plan")] == [later.id]
            assert not await asyncio.to_thread(store.events, run.job.id)

    asyncio.run(story())


def test_what_is_refused_while_it_waits_takes_no_place(tmp_path):
    async def story():
        async with serving(tmp_path, timeouts=DatabaseTimeouts(record=0.2)) as (dispatcher, _):
            gate = tmp_path / "gate"
            first = await dispatcher.submit(spec("wait_for_file", payload={"file": str(gate)}))
            with locked(tmp_path / "jobs.sqlite"), pytest.raises(DatabaseUnavailable):
                await dispatcher.submit(spec("warm"))
            assert list(dispatcher._attempts) == [first.id]
            assert dispatcher._scheduler.queue("plan").num_waiting == 0
            gate.touch()
            assert (await dispatcher.wait(first.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


def test_one_key_is_one_job_however_often_it_is_sent_at_once(tmp_path):
    async def story():
        async with serving(tmp_path) as (dispatcher, store):
            wanted = spec("warm", key="k", request_digest="1")
            jobs = await asyncio.gather(*(dispatcher.submit(wanted) for _ in range(5)))
            assert len({job.id for job in jobs}) == 1
            with pytest.raises(IdempotencyConflict):
                await dispatcher.submit(spec("warm", key="k", request_digest="2"))
            assert (await dispatcher.wait(jobs[0].id, GUARD)).state is JobState.SUCCEEDED
            await eventually(lambda: not dispatcher._attempts)
            assert [job.id for job in await asyncio.to_thread(store.page, "plan")] == [jobs[0].id]

    asyncio.run(story())


def test_a_success_that_is_told_outlives_the_server_at_once_and_soon_a_power_cut(tmp_path):
    """What could not be had again is durable before it is told, as is every other end."""

    async def ended(dispatcher, wanted):
        job = await dispatcher.submit(wanted)
        text = await dispatcher.wait_text(job.id, GUARD)
        assert state_on_disk(tmp_path, job.id) == text.summary.state
        return text.summary.state

    async def story():
        async with serving(tmp_path) as (dispatcher, store):
            told = watched(store)
            assert await ended(dispatcher, spec("repeat")) is JobState.SUCCEEDED
            assert told == [True, False]  # that it is there and has begun; its end
            await eventually(lambda: told[2:] == ["flush"])
            cut = {"cut_short": ["refine"]}
            for wanted in (
                spec("repeat", max_attempts=1),
                spec("repeat", payload=cut),
                spec("warm"),
                spec("refuse"),
            ):
                told.clear()
                await ended(dispatcher, wanted)
                assert told[-1] is True

    asyncio.run(story())


def test_a_flush_has_the_disk_take_the_log(tmp_path, monkeypatch):
    taken = []
    named = "/proc/self/fd/{}".format
    monkeypatch.setattr(os, "fsync", lambda file: taken.append(str(Path(named(file)).readlink())))
    engine = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    store = JobStore(engine)
    store.open()
    store.insert(spec("warm"))
    store.flush()
    engine.dispose()
    assert taken == [f"{tmp_path}/jobs.sqlite-wal"]
    JobStore(open_engine("sqlite://")).flush()


def test_a_job_is_on_its_way_to_a_worker_before_the_writer_is_asked():
    """They share an interpreter: what is sent first does not wait for the other's turn."""

    async def story():
        told, runs = [], []

        class Recording:
            store = SimpleNamespace(insert_drafts=print)

            async def write(self, work, *, within):
                told.append("asked to write")
                return SimpleNamespace(jobs=[SimpleNamespace(id="a")], are_new=True, starts={})

            def publish(self, _, events):
                assert not events

        class Run:
            def confirm(self, _, start):
                told.append("entered")

        async def send():
            told.append("sent")

        def seat(_, __, text):
            assert text == "{}"
            # As attempts do, whose first step is taken at once.
            runs.append(Scheduler({}).begin(send()))
            return Run()

        attempts = SimpleNamespace(schedule=seat, num_starting=lambda *_, **__: 0)
        queue = SimpleNamespace(max_waiting=1)
        scheduler = SimpleNamespace(queue=lambda _: queue, retry_after=lambda _: 1)
        await JobSubmission(Recording(), attempts, scheduler, GUARD).submit(spec("touch"))
        assert told == ["sent", "asked to write", "entered"]

    asyncio.run(story())


@pytest.mark.parametrize("is_refused", [False, True])
def test_a_job_whose_files_cannot_be_copied_yet_runs_later(tmp_path, monkeypatch, is_refused):
    """Also if that is known before the table has the job; one that it never has is forgotten."""
    monkeypatch.setattr("service.jobs.dispatch.attempt._RETRY_PERIOD", 0.0)
    faults, bring = [OSError(28, "No space left on device")] * 3, ThreadWorker.bring

    async def fail_at_first(self, artifacts):
        if faults:
            raise faults.pop()
        await bring(self, artifacts)

    monkeypatch.setattr(ThreadWorker, "bring", fail_at_first)

    async def story():
        async with serving(tmp_path, timeouts=DatabaseTimeouts(record=0.2)) as (dispatcher, _):
            if not is_refused:
                job = await dispatcher.submit(spec("touch", payload={"file": str(tmp_path / "x")}))
                assert (await dispatcher.wait(job.id, GUARD)).state is JobState.SUCCEEDED
                return
            with locked(tmp_path / "jobs.sqlite"), pytest.raises(DatabaseUnavailable):
                await dispatcher.submit(spec("touch", payload={"file": str(tmp_path / "x")}))
            await eventually(lambda: not dispatcher._attempts)

    asyncio.run(story())
    assert (tmp_path / "x").exists() is not is_refused


def test_a_job_that_is_scheduled_is_with_an_idle_worker_at_once():
    async def story():
        runs = []

        class Idle:
            generation, is_lost, fault = 0, False, None

            async def open(self, _):
                pass

            async def ready(self):
                pass

            async def bring(self, _):
                pass

            async def run(self, run):
                runs.append(run.task)
                await asyncio.Event().wait()

            async def close(self):
                pass

        drafted = draft(spec("touch"))
        scheduler = Scheduler({drafted.job.queue: JobQueue(drafted.job.queue, [Idle()], 9)})
        await scheduler.open(None)
        await asyncio.sleep(0)
        attempts = Attempts(None, scheduler, Observer(), NoConclusion)
        attempts.schedule(drafted.job, {})
        assert runs == [drafted.job.task]
        await scheduler.close()

    asyncio.run(story())
