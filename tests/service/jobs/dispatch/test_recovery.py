"""Servers that stop, and servers that are killed, lose nothing and leave nothing running."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

from planning.errors import Canceled
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.errors import DatabaseInUse
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from tests.profiles import only_campaign
from tests.service.jobs.conftest import GUARD, running, spec
from tests.service.jobs.worker.test_process_worker import is_alive

ROOT = Path(__file__).parents[4]

SERVER = """
import asyncio, sys
from pathlib import Path
from tests.service.jobs.conftest import running, spec

async def main(folder):
    async with running(folder, workers=2) as (dispatcher, store):
        busy = [await dispatcher.submit(spec("wait_for_file", payload={"file": str(folder / "go")}))
                for _ in range(2)]
        once = await dispatcher.submit(spec("hang", max_attempts=1, priority=9))
        for i in range(20):
            await dispatcher.submit(spec("touch", payload={"file": str(folder / f"ran{i}")}))
        pids = set()
        for job in (once, busy[0]):
            async for event in dispatcher.subscribe(job.id):
                if "pid" in event.data:
                    pids.add(event.data["pid"])
                    break
        print(*pids, flush=True)
        await asyncio.sleep(60)

if __name__ == "__main__":
    asyncio.run(main(Path(sys.argv[1])))
"""


def start_server(folder, script=SERVER):
    file = folder / "server.py"
    file.write_text(script)
    return subprocess.Popen(
        [sys.executable, file, folder],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )


@only_campaign("3 s")
def test_a_server_killed_with_many_jobs_ends_all_of_them_after_a_restart(tmp_path):
    with start_server(tmp_path) as server:
        workers = [int(pid) for pid in server.stdout.readline().split()]
        assert len(workers) == 2
        with pytest.raises(DatabaseInUse):
            DispatcherLock(open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")).take()
        server.send_signal(signal.SIGKILL)
    until = time.monotonic() + GUARD
    while any(is_alive(worker) for worker in workers):
        assert time.monotonic() < until, "a worker outlived its server"
    (tmp_path / "go").touch()

    async def story():
        async with running(tmp_path, workers=2) as (dispatcher, store):
            jobs = store.page("plan", limit=100)
            ended = [await dispatcher.wait(job.id, GUARD) for job in jobs]
            assert Counter(job.state.value for job in ended) == {"succeeded": 22, "failed": 1}
            [failed] = [job for job in ended if job.state == "failed"]
            assert failed.failure["code"] == "server_restarted"
            for job in ended:
                numbers = [event.number for event in store.events(job.id)]
                assert numbers == list(range(1, len(numbers) + 1))
            runs = [len((tmp_path / f"ran{i}").read_text().split()) for i in range(20)]
            assert set(runs) == {1}

    asyncio.run(story())


def test_a_server_that_stops_queues_again_what_ran_and_does_not_count_it(tmp_path):
    async def first():
        async with running(tmp_path, workers=2) as (dispatcher, _):
            again = await dispatcher.submit(
                spec("wait_for_file", payload={"file": str(tmp_path / "go")})
            )
            once = await dispatcher.submit(spec("hang", max_attempts=1))
            later = await dispatcher.submit(spec("echo"))
            for job in (again, once):
                async for event in dispatcher.subscribe(job.id):
                    if "pid" in event.data:
                        break
            told = asyncio.Queue()
            follower = asyncio.create_task(collect(dispatcher, later.id, told))
            assert await told.get() == "queued"
        assert await follower == ["queued"]
        return again.id, once.id, later.id

    async def second(again, once, later):
        async with running(tmp_path) as (dispatcher, store):
            assert store.get(once).failure["code"] == "server_restarted"
            assert store.get(again).attempts <= 1
            (tmp_path / "go").touch()
            job = await dispatcher.wait(again, GUARD)
            assert (job.state, job.attempts) == ("succeeded", 1)
            assert (await dispatcher.wait(later, GUARD)).state == "succeeded"
            assert await collect(dispatcher, again) == [
                "queued",
                "started",
                "stage",
                "requeued",
                "started",
                "stage",
                "finished",
            ]

    ids = asyncio.run(first())
    asyncio.run(second(*ids))


async def collect(dispatcher, identifier, told=None):
    """The types of all events, which are put into a queue as they come."""
    types = []
    async for event in dispatcher.subscribe(identifier):
        types.append(event.type)
        if told is not None:
            told.put_nowait(event.type)
    return types


def test_what_was_to_be_canceled_is_canceled_and_unknown_lanes_fail(tmp_path):
    engine = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    store = JobStore(engine)
    store.open()
    unwanted, _ = store.insert(spec("hang"))
    store.start(unwanted.id)
    store.request_cancel(unwanted.id)
    stray, _ = store.insert(spec("echo", queue="gone"))
    engine.dispose()

    async def story():
        async with running(tmp_path) as (_, opened):
            assert opened.get(unwanted.id).state == "canceled"
            assert opened.get(unwanted.id).failure["code"] == Canceled.code
            assert opened.get(stray.id).state == "failed"
            assert opened.unfinished() == []

    asyncio.run(story())


def test_jobs_survive_workers_that_are_killed_at_random(tmp_path):
    async def story():
        async with running(tmp_path, workers=2) as (dispatcher, store):
            ids = [(await dispatcher.submit(spec("spin", max_attempts=50))).id for _ in range(2)]
            echoes = [
                (await dispatcher.submit(spec("echo", max_attempts=50))).id for _ in range(20)
            ]
            seen = dict.fromkeys(ids, 0)
            for _ in range(5):
                for identifier in ids:
                    async for event in dispatcher.subscribe(identifier, seen[identifier]):
                        seen[identifier] = event.number
                        if "pid" in event.data:
                            os.kill(event.data["pid"], signal.SIGKILL)
                            break
            for identifier in ids:
                await dispatcher.cancel(identifier)
            for identifier in [*ids, *echoes]:
                assert (await dispatcher.wait(identifier, GUARD)).state.is_final
            assert {store.get(identifier).state.value for identifier in echoes} == {"succeeded"}
            assert min(store.get(identifier).attempts for identifier in ids) >= 5

    asyncio.run(story())


def test_followers_see_the_same_numbers_live_late_and_after_a_restart(tmp_path):
    async def numbers(dispatcher, identifier, after=0):
        return [event.number async for event in dispatcher.subscribe(identifier, after)]

    async def first():
        async with running(tmp_path) as (dispatcher, _):
            job = await dispatcher.submit(spec("chatter", payload={"count": 600, "size": 10}))
            live = [asyncio.create_task(numbers(dispatcher, job.id, i * 40)) for i in range(10)]
            for i, task in enumerate(live):
                assert await task == list(range(i * 40 + 1, 604))
            return job.id

    async def second(identifier):
        async with running(tmp_path, inline=True) as (dispatcher, _):
            assert await numbers(dispatcher, identifier, 599) == [600, 601, 602, 603]
            assert await numbers(dispatcher, identifier, 10**30) == []

    asyncio.run(second(asyncio.run(first())))


def test_a_task_that_returns_although_it_was_canceled_has_succeeded(tmp_path):
    async def story():
        async with running(tmp_path) as (dispatcher, _):
            job = await dispatcher.submit(spec("stubborn", payload={"a": 1}))
            async for event in dispatcher.subscribe(job.id):
                if "pid" in event.data:
                    break
            assert (await dispatcher.cancel(job.id)).is_cancel_requested
            ended = await dispatcher.wait(job.id, GUARD)
            assert (ended.state, ended.result) == ("succeeded", {"kept": {"a": 1}})

    asyncio.run(story())
