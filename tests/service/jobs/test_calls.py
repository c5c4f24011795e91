"""Short calls share slots with jobs, and leave nothing behind."""

import asyncio
import signal

import pytest

from planning.errors import DeadlineExceeded
from service.jobs.errors import InternalError, QueueFull, WorkerCrashed
from tests.service.jobs.conftest import GUARD, TASKS, running, spec
from tests.service.servers import until


def call(dispatcher, task, payload=None, allowed=GUARD):
    return dispatcher.call(f"{TASKS}:{task}", payload or {}, lane="plan", allowed=allowed)


def test_calls_that_crash_or_blunder_say_so(tmp_path):
    async def story():
        async with running(tmp_path) as (dispatcher, store):
            with pytest.raises(WorkerCrashed) as crash:
                await call(dispatcher, "segfault")
            assert crash.value.evidence["exit_code"] == -signal.SIGSEGV
            with pytest.raises(InternalError, match="KeyError"):
                await call(dispatcher, "blunder")
            marker = {"marker": str(tmp_path / "marker")}
            assert await call(dispatcher, "die_once", marker) == {"attempt": 2}
            assert store.counts() == {}

    asyncio.run(story())


def test_a_call_waits_its_turn_but_no_longer_than_it_may(tmp_path):
    async def story():
        async with running(tmp_path, max_waiting=3) as (dispatcher, _):
            file = tmp_path / "go"
            busy = await dispatcher.submit(spec("wait_for_file", payload={"file": str(file)}))
            with pytest.raises(DeadlineExceeded):
                await call(dispatcher, "echo", allowed=0.1)
            waiting = [asyncio.create_task(call(dispatcher, "echo")) for _ in range(3)]
            await asyncio.sleep(0.02)
            with pytest.raises(QueueFull) as refusal:
                await call(dispatcher, "echo")
            assert refusal.value.evidence["queued"] == 3
            waiting[0].cancel()
            await asyncio.sleep(0.02)
            waiting[0] = asyncio.create_task(call(dispatcher, "echo"))
            file.touch()
            answers = await asyncio.gather(*waiting)
            assert [answer["echo"] for answer in answers] == [{}] * 3
            assert (await dispatcher.wait(busy.id, GUARD)).state == "succeeded"

    asyncio.run(story())


def test_a_call_that_nobody_waits_for_ends(tmp_path):
    async def story():
        async with running(tmp_path) as (dispatcher, _):
            begun = tmp_path / "begun"
            waits = {"file": str(tmp_path / "never"), "begun": str(begun)}
            forgotten = asyncio.create_task(call(dispatcher, "wait_for_file", waits))
            await asyncio.to_thread(until, begun.exists)
            forgotten.cancel()
            assert (await call(dispatcher, "echo"))["echo"] == {}

    asyncio.run(story())
