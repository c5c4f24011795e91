"""Jobs end, whatever their tasks do, and nothing but the job at fault suffers."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from planning.errors import DeadlineExceeded, GoalUnreachable
from service.jobs.dispatch.calls import Call
from service.jobs.errors import DatabaseInUse, IdempotencyConflict, QueueFull, UnknownJob
from service.jobs.job import Job
from service.jobs.states import JobState
from tests.service.jobs.conftest import GUARD, running, spec


async def until_running(dispatcher: object, store: object, job: Job) -> int:
    """Wait until a task has told its process's number, and return it."""
    async for event in dispatcher.subscribe(job.id):
        if "pid" in event.data:
            return event.data["pid"]
    raise AssertionError("the job ended before it began")


@pytest.mark.parametrize("inline", [True, False])
def test_results_failures_and_blunders_come_back(tmp_path: Path, inline: bool) -> None:
    async def story() -> None:
        async with running(tmp_path, inline=inline) as (dispatcher, store):
            names = ["echo", "refuse", "blunder", "leave", "interrupt", "secret"]
            jobs = [await dispatcher.submit(spec(name, payload={"a": 1})) for name in names]
            ended = [await dispatcher.wait(job.id, GUARD) for job in jobs]
            assert [job.state for job in ended] == ["succeeded"] + ["failed"] * 5
            assert ended[0].result["echo"] == {"a": 1}
            assert ended[1].failure == {
                "code": "goal_unreachable",
                "stage": "goals",
                "detail": "too far",
                "evidence": {"metres": 2.0},
                "timings": {},
            }
            codes = [job.failure["code"] for job in ended[2:]]
            assert codes == ["internal_error", "worker_crashed", "worker_crashed", "internal_error"]
            assert ended[3].failure["evidence"]["reason"] == "SystemExit: 3"
            assert ended[2].failure["evidence"]["exception"] == "KeyError"
            types = [event.type for event in store.events(jobs[0].id)]
            assert types == ["queued", "started", "stage", "finished"]
            assert ended[0].stage == "echo"
            assert ended[0].progress == 1.0

    asyncio.run(story())


def test_a_crash_is_tried_again_and_then_told(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, store):
            flaky = await dispatcher.submit(
                spec("die_once", payload={"marker": str(tmp_path / "m")})
            )
            fatal = await dispatcher.submit(spec("segfault"))
            healthy = await dispatcher.submit(spec("echo"))
            assert (await dispatcher.wait(flaky.id, GUARD)).result == {"attempt": 2}
            dead = await dispatcher.wait(fatal.id, GUARD)
            assert dead.failure["code"] == "worker_crashed"
            evidence = dead.failure["evidence"]
            assert evidence["exit_code"] == -signal.SIGSEGV
            assert evidence["signal"] == "SIGSEGV"
            assert evidence["attempts"] == 2
            assert (await dispatcher.wait(healthy.id, GUARD)).state is JobState.SUCCEEDED
            assert [e.number for e in store.events(fatal.id)] == [1, 2, 3, 4, 5]

    asyncio.run(story())


def test_a_worker_killed_from_outside_loses_nothing(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, store):
            job = await dispatcher.submit(spec("spin"))
            os.kill(await until_running(dispatcher, store, job), signal.SIGKILL)
            second = 0
            async for event in dispatcher.subscribe(job.id, 3):
                second = event.data.get("pid", 0)
                if second:
                    break
            await dispatcher.cancel(job.id)
            assert (await dispatcher.wait(job.id, GUARD)).state is JobState.CANCELED
            idle = await dispatcher.submit(spec("echo"))
            os.kill((await dispatcher.wait(idle.id, GUARD)).result["pid"], signal.SIGKILL)
            await asyncio.sleep(0.1)
            after = await dispatcher.submit(spec("echo"))
            assert (await dispatcher.wait(after.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


def test_a_deadline_ends_native_code(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, _):
            job = await dispatcher.submit(spec("hang", time_limit=0.5))
            ended = await dispatcher.wait(job.id, GUARD)
            failure = ended.failure
            assert (failure["code"], failure["stage"]) == ("deadline_exceeded", "hang")
            assert failure["evidence"] == {"allowed": 0.5, "during": "hang"}
            timings = failure["timings"]
            assert (set(timings), timings["load"]) == ({"load", "hang", "total"}, 0.125)
            assert timings["load"] + timings["hang"] == pytest.approx(timings["total"])
            assert timings["total"] >= 0.5
            after = await dispatcher.submit(spec("echo"))
            assert (await dispatcher.wait(after.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


@pytest.mark.parametrize("task", ["spin", "hang"])
def test_cancel_works_in_every_state_and_again(tmp_path: Path, task: str) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, store):
            busy = await dispatcher.submit(spec(task))
            waiting = await dispatcher.submit(spec("echo"))
            await until_running(dispatcher, store, busy)
            assert (await dispatcher.cancel(waiting.id)).state is JobState.CANCELED
            await dispatcher.cancel(busy.id)
            await dispatcher.cancel(busy.id)
            ended = await dispatcher.wait(busy.id, GUARD)
            assert ended.state is JobState.CANCELED
            assert ended.failure["code"] == "canceled"
            assert (await dispatcher.cancel(busy.id)).state is JobState.CANCELED
            assert [e.type for e in store.events(waiting.id)] == ["queued", "finished"]
            after = await dispatcher.submit(spec("echo"))
            assert (await dispatcher.wait(after.id, GUARD)).state is JobState.SUCCEEDED
            assert (await dispatcher.cancel(after.id)).state is JobState.SUCCEEDED

    asyncio.run(story())


def test_a_cancel_right_at_the_start_is_not_missed(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, _):
            for _ in range(5):
                job = await dispatcher.submit(spec("spin"))
                await asyncio.sleep(0.001)
                await dispatcher.cancel(job.id)
                assert (await dispatcher.wait(job.id, GUARD)).state is JobState.CANCELED

    asyncio.run(story())


def test_events_are_numbered_without_gaps_and_replayed(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, store):
            job = await dispatcher.submit(spec("chatter", payload={"count": 40, "size": 9000}))
            live, late = await asyncio.gather(
                _numbers(dispatcher, job.id, 0), _numbers(dispatcher, job.id, 7)
            )
            again = await _numbers(dispatcher, job.id, 0)
            assert live == again == list(range(1, 44))
            assert late == list(range(8, 44))
            texts = [e.data["text"] for e in store.events(job.id) if e.type == "note"]
            assert texts == ["x" * 9000] * 40

    asyncio.run(story())


async def _numbers(dispatcher: object, identifier: str, after: int) -> list[int]:
    return [event.number async for event in dispatcher.subscribe(identifier, after)]


def test_idempotency_keys(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, _):
            first = await dispatcher.submit(spec("echo", key="k", request_digest="1"))
            assert (
                await dispatcher.submit(spec("echo", key="k", request_digest="1"))
            ).id == first.id
            with pytest.raises(IdempotencyConflict):
                await dispatcher.submit(spec("echo", key="k", request_digest="2"))
            with pytest.raises(UnknownJob, match="job_nowhere"):
                await dispatcher.wait("job_nowhere", 1)

    asyncio.run(story())


def test_admission_is_limited(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, max_waiting=2) as (dispatcher, store):
            busy = await dispatcher.submit(spec("spin"))
            await until_running(dispatcher, store, busy)
            waiting = [await dispatcher.submit(spec("echo")) for _ in range(2)]
            with pytest.raises(QueueFull) as refusal:
                await dispatcher.submit(spec("echo"))
            assert refusal.value.evidence["retry_after"] > 0
            await dispatcher.cancel(busy.id)
            for job in waiting:
                assert (await dispatcher.wait(job.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


def asked(task: str, payload: dict | None = None, allowed: float = GUARD) -> Call:
    return Call(f"fake.{task}", payload or {}, "plan", allowed, GUARD)


def test_short_calls_return_raise_and_time_out(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path) as (dispatcher, _):
            answer = await dispatcher.call(asked("echo", {"b": 2}))
            assert answer.content["echo"] == {"b": 2}
            with pytest.raises(GoalUnreachable, match="too far"):
                await dispatcher.call(asked("refuse"))
            with pytest.raises(DeadlineExceeded):
                await dispatcher.call(asked("hang", allowed=0.5))

    asyncio.run(story())


def test_two_dispatchers_on_one_database_are_refused(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, inline=True):
            with pytest.raises(DatabaseInUse):
                async with running(tmp_path, inline=True):
                    pass

    asyncio.run(story())


SERVER = """
import asyncio, sys
from pathlib import Path
from tests.service.jobs.conftest import running, spec

async def main():
    async with running(Path(sys.argv[1])) as (dispatcher, store):
        for name in ("spin", "echo", "echo"):
            print((await dispatcher.submit(spec(name))).id, flush=True)
        async for event in dispatcher.subscribe(store.page("plan")[-1].id):
            if "pid" in event.data:
                print(event.data["pid"], flush=True)
        await asyncio.sleep(60)

if __name__ == "__main__":
    asyncio.run(main())
"""


def test_a_server_killed_at_work_loses_nothing_and_leaves_no_orphan(tmp_path: Path) -> None:
    script = tmp_path / "server.py"
    script.write_text(SERVER)
    server = subprocess.Popen(
        [sys.executable, script, tmp_path],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(Path.cwd())},
    )
    lines = [server.stdout.readline().strip() for _ in range(4)]
    server.kill()
    server.wait()
    server.stdout.close()
    worker = int(lines[3])
    until = time.monotonic() + GUARD
    while Path(f"/proc/{worker}").exists() and not _is_zombie(worker):
        assert time.monotonic() < until, f"worker {worker} outlived its server"

    async def story() -> None:
        async with running(tmp_path) as (dispatcher, store):
            seen = [event.type for event in store.events(lines[0])]
            assert "requeued" in seen
            async for event in dispatcher.subscribe(lines[0], seen.index("requeued") + 1):
                if "pid" in event.data:
                    break
            assert store.get(lines[0]).attempts == 2
            await dispatcher.cancel(lines[0])
            for identifier in lines[:3]:
                assert (await dispatcher.wait(identifier, GUARD)).state.is_final
            assert not store.unfinished()

    asyncio.run(story())


def _is_zombie(pid: int) -> bool:
    try:
        return ") Z " in Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):  # gone before or while it is read
        return True
