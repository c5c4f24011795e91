"""Short calls share workers with jobs, and leave nothing behind."""

import asyncio
import signal

import pytest

from service.jobs.dispatch.calls import Call
from service.jobs.dispatch.scheduling.queue import Share
from service.jobs.errors import InternalError, QueueFull, QueueTimeout, WorkerCrashed
from tests.service.jobs.conftest import GUARD, running, spec
from tests.service.servers import until


async def call(dispatcher, task, payload=None, **given):
    return (await answer(dispatcher, task, payload, **given)).content


def answer(dispatcher, task, payload=None, allowed=GUARD, patience=GUARD, **about):
    question = Call(f"fake.{task}", payload or {}, "plan", allowed, patience, **about)
    return dispatcher.call(question)


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
            with pytest.raises(QueueTimeout) as late:
                await call(dispatcher, "echo", patience=0.1)
            assert late.value.evidence["waited"] == 0.1
            assert late.value.evidence["retry_after"] >= 1
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


def test_large_scenes_do_not_keep_short_questions_waiting(tmp_path):
    """While one scene is loaded and others wait to be, two workers answer what is short."""

    async def story():
        async with running(tmp_path, workers=2, share=Share(2, reserved=1)) as (dispatcher, _):
            file, begun = tmp_path / "go", tmp_path / "begun"
            payload = {"file": str(file), "begun": str(begun)}
            loads = [
                asyncio.create_task(call(dispatcher, "wait_for_file", payload, digest_field="pid"))
                for _ in range(3)
            ]
            await asyncio.to_thread(until, begun.exists)
            for _ in range(3):
                assert (await call(dispatcher, "echo"))["echo"] == {}
            assert not any(load.done() for load in loads)
            file.touch()
            pids = [told["pid"] for told in await asyncio.gather(*loads)]
            # What was left by a load is where the next question about it goes.
            assert (await call(dispatcher, "echo", world_digest=pids[-1]))["pid"] == pids[-1]

    asyncio.run(story())


def test_waiting_is_not_working(tmp_path):
    """A call that may work for 1 s has waited longer, which is told and held against nothing."""

    async def story():
        async with running(tmp_path) as (dispatcher, _):
            file, begun = tmp_path / "go", tmp_path / "begun"
            payload = {"file": str(file), "begun": str(begun)}
            await dispatcher.submit(spec("wait_for_file", payload=payload))
            await asyncio.to_thread(until, begun.exists)
            waiting = asyncio.create_task(answer(dispatcher, "echo", allowed=1.0))
            await asyncio.sleep(1.2)
            file.touch()
            told = await waiting
            assert told.content["echo"] == {}
            assert told.waited > 1.1

    asyncio.run(story())


@pytest.mark.parametrize(("task", "is_kept"), [("spin_until_told", True), ("hang_quietly", False)])
def test_a_call_that_is_given_up_frees_its_worker_and_spares_it_if_it_ends(tmp_path, task, is_kept):
    async def story():
        async with running(tmp_path) as (dispatcher, _):
            pid = (await call(dispatcher, "echo"))["pid"]
            begun, ended = tmp_path / "begun", tmp_path / "ended"
            payload = {"begun": str(begun), "ended": str(ended)}
            given_up = asyncio.create_task(call(dispatcher, task, payload))
            await asyncio.to_thread(until, begun.exists)
            given_up.cancel()
            assert ((await call(dispatcher, "echo"))["pid"] == pid) is is_kept
            assert ended.exists() is is_kept

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
