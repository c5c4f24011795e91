"""Jobs and calls get workers as their queue says: by priority, and by turns of clients."""

import asyncio

from tests.service.jobs.conftest import GUARD, running, spec
from tests.service.jobs.dispatch.test_calls import call


def test_jobs_run_by_priority_and_clients_take_turns(tmp_path):
    async def story():
        async with running(tmp_path, inline=True) as (dispatcher, store):
            file = tmp_path / "go"
            first = await dispatcher.submit(spec("wait_for_file", payload={"file": str(file)}))
            async for event in dispatcher.subscribe(first.id):
                if event.type == "started":
                    break
            wanted = ["a0", "a1", "a2", "b0", "b1", "c0!"]
            jobs = {}
            for name in wanted:
                terms = {"client": name[0], "priority": int("!" in name)}
                jobs[name] = await dispatcher.submit(spec("echo", **terms))
            file.touch()
            ended = {name: await dispatcher.wait(job.id, GUARD) for name, job in jobs.items()}
            assert sorted(ended, key=lambda name: ended[name].started_at) == [
                "c0!", "a0", "b0", "a1", "b1", "a2"
            ]  # fmt: skip
            assert {store.get(job.id).client for job in jobs.values()} == {"a", "b", "c"}

    asyncio.run(story())


def test_jobs_that_a_server_left_keep_client_and_priority(tmp_path):
    async def left():
        async with running(tmp_path, inline=True) as (dispatcher, _):
            dispatcher._scheduler.pause()
            await dispatcher.submit(spec("echo", client="a"))
            for i in range(2):
                await dispatcher.submit(spec("echo", client="a", payload={"i": i}))
            await dispatcher.submit(spec("echo", client="b"))
            await dispatcher.submit(spec("echo", client="b", priority=1))

    async def taken_up():
        async with running(tmp_path, inline=True) as (dispatcher, store):
            jobs = store.page("plan")
            ended = [await dispatcher.wait(job.id, GUARD) for job in reversed(jobs)]
            by_start = sorted(ended, key=lambda job: job.started_at)
            assert [(job.client, job.priority) for job in by_start] == [
                ("b", 1), ("a", 0), ("b", 0), ("a", 0), ("a", 0)
            ]  # fmt: skip

    asyncio.run(left())
    asyncio.run(taken_up())


def test_calls_of_clients_take_turns(tmp_path):
    async def story():
        async with running(tmp_path, inline=True) as (dispatcher, _):
            file, answered = tmp_path / "go", []
            busy = asyncio.create_task(call(dispatcher, "wait_for_file", {"file": str(file)}))

            async def ask(name):
                await call(dispatcher, "echo", client=name[0])
                answered.append(name)

            await asyncio.sleep(0)
            async with asyncio.TaskGroup() as group:
                for name in ("a0", "a1", "a2", "b0", "b1"):
                    group.create_task(ask(name))
                    await asyncio.sleep(0)
                file.touch()
            await busy
            assert answered == ["a0", "b0", "a1", "b1", "a2"]

    asyncio.run(story())
