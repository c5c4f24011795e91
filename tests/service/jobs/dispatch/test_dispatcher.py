"""Jobs end, whatever their tasks do, and nothing but the job at fault suffers."""

import asyncio
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

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
