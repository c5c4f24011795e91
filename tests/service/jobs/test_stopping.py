"""What runs can be stopped and steered whatever the database does, and no end of a job is lost."""

import asyncio
import os
import signal
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from planning.errors import IllegalTransition
from service.errors import ServerStopping
from service.jobs.dispatch.attempt import Attempt
from service.jobs.dispatch.calls import Call
from service.jobs.states import JobState
from tests.profiles import num_cases, only_campaign, pairs
from tests.service.jobs.conftest import GUARD, running, spec
from tests.service.jobs.databases import locked


def moving(folder: Path, **options):
    """A job whose robot comes to rest when it is canceled; `rest` is there from then on."""
    silence = options.pop("silence", 60.0)
    payload = {"rest": str(folder / "rest"), "silence": silence}
    return spec("move", payload=payload, max_attempts=1, **options)


async def eventually(ask):
    """What `ask` returns once it is true; the time is for what hangs."""
    async with asyncio.timeout(GUARD):
        while not (found := ask()):  # noqa: ASYNC110  (databases and processes set no events)
            await asyncio.sleep(0.01)
        return found


@asynccontextmanager
async def refusing(kind, folder, disk):
    """A database that takes nothing meanwhile."""
    if kind == "locked":
        with locked(folder / "jobs.sqlite"):
            yield
        return
    disk.fill()
    yield
    disk.free()


@pytest.mark.campaign
@pytest.mark.parametrize(("kind", "inline"), pairs(["locked", "full"], [True, False]))
def test_a_run_comes_to_rest_although_the_database_takes_nothing(
    tmp_path: Path, kind: str, inline: bool
) -> None:
    async def story() -> None:
        disks: list = []
        async with running(tmp_path, inline=inline, cancel_grace=GUARD, disks=disks) as (
            dispatcher,
            store,
        ):
            job = await dispatcher.submit(moving(tmp_path))
            live = dispatcher.attempt_of(job.id)
            await eventually(lambda: store.last_event(job.id, "status"))
            async with refusing(kind, tmp_path, disks[0]):
                # A full disk has room in the pages that there are: these statuses fill them.
                if kind == "full":
                    await eventually(lambda: "events" in live.unrecorded)
                told = await dispatcher.cancel(job.id)
                assert told.is_cancel_requested
                assert told.state is JobState.RUNNING
                if kind == "locked":
                    assert live.unrecorded == ["cancel"] or "end" in live.unrecorded
                await eventually((tmp_path / "rest").exists)
                await eventually(lambda: "end" in live.unrecorded)
                place = live.latest("status")["place"]
                assert store.get(job.id).state is JobState.RUNNING
            ended = await dispatcher.wait(job.id, GUARD)
            assert ended.state is JobState.CANCELED
            assert ended.failure["evidence"]["place"] == int((tmp_path / "rest").read_text())
            # Where it came to rest is known: what could not be recorded in time was kept.
            assert store.last_event(job.id, "status").data["place"] == place
            numbers = [event.number for event in store.events(job.id)]
            assert numbers == list(range(1, len(numbers) + 1))

    asyncio.run(story())


def test_what_waits_is_canceled_although_the_database_takes_nothing(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, cancel_grace=GUARD) as (dispatcher, store):
            busy = await dispatcher.submit(moving(tmp_path))
            await eventually(lambda: store.last_event(busy.id, "status"))
            waits = await dispatcher.submit(spec("touch", payload={"file": str(tmp_path / "ran")}))
            with locked(tmp_path / "jobs.sqlite"):
                assert (await dispatcher.cancel(waits.id)).is_cancel_requested
                assert dispatcher.attempt_of(waits.id).unrecorded == ["cancel"]
                await dispatcher.cancel(busy.id)
                await eventually((tmp_path / "rest").exists)
            for job in (busy, waits):
                assert (await dispatcher.wait(job.id, GUARD)).state is JobState.CANCELED
            assert not (tmp_path / "ran").exists()
            assert dispatcher.attempt_of(waits.id) is None

    asyncio.run(story())


@pytest.mark.parametrize("inline", [True, False])
def test_what_is_asked_of_a_run_is_obeyed_first_and_recorded_later(
    tmp_path: Path, inline: bool
) -> None:
    async def story() -> None:
        async with running(tmp_path, inline=inline) as (dispatcher, store):
            job = await dispatcher.submit(moving(tmp_path))
            live = dispatcher.attempt_of(job.id)
            await eventually(lambda: store.last_event(job.id, "status"))
            with locked(tmp_path / "jobs.sqlite"):
                await dispatcher.control(job.id, {"a": 1})
                assert "controls" in live.unrecorded
                await dispatcher.control(job.id, {"b": 2})
                await eventually(lambda: live.latest("status")["asked"] == {"a": 1, "b": 2})
                await dispatcher.control(job.id, {"goal": live.latest("status")["place"] + 50})
                await eventually(lambda: "end" in live.unrecorded)
                with pytest.raises(IllegalTransition):
                    await dispatcher.control(job.id, {"b": 3})
            assert (await dispatcher.wait(job.id, GUARD)).state is JobState.SUCCEEDED
            with pytest.raises(IllegalTransition):
                await dispatcher.control(job.id, {"b": 3})

    asyncio.run(story())


def test_what_was_asked_of_a_job_that_waits_outlives_the_server(tmp_path: Path) -> None:
    async def first() -> str:
        async with running(tmp_path, workers=1, cancel_grace=GUARD) as (dispatcher, store):
            busy = await dispatcher.submit(moving(tmp_path))
            await eventually(lambda: store.last_event(busy.id, "status"))
            waits = await dispatcher.submit(moving(tmp_path))
            await dispatcher.control(waits.id, {"goal": 3})
            return waits.id

    async def second(identifier: str) -> None:
        async with running(tmp_path) as (dispatcher, _):
            ended = await dispatcher.wait(identifier, GUARD)
            assert ended.result == {"place": 3}

    asyncio.run(second(asyncio.run(first())))


@only_campaign("10 s")
@pytest.mark.campaign
@pytest.mark.parametrize("kind", ["full", "locked"][: num_cases(1, 2)])
def test_a_result_is_kept_until_the_database_takes_it(tmp_path: Path, kind: str) -> None:
    async def story() -> None:
        disks: list = []
        async with running(tmp_path, workers=2, disks=disks) as (dispatcher, store):
            payload = {"file": str(tmp_path / "go"), "begun": str(tmp_path / "begun")}
            job = await dispatcher.submit(
                spec("wait_for_file", payload=payload | {"count": 100_000})
            )
            live = dispatcher.attempt_of(job.id)
            await eventually((tmp_path / "begun").exists)
            async with refusing(kind, tmp_path, disks[0]):
                (tmp_path / "go").touch()
                # Longer than the writer asks again by itself: what failed is not given up.
                await eventually(lambda: "end" in live.unrecorded)
                await asyncio.sleep(6.0)
                assert live.unrecorded == ["end"]
                assert store.get(job.id).state is JobState.RUNNING
            ended = await dispatcher.wait(job.id, GUARD)
            assert (ended.state, ended.failure) == (JobState.SUCCEEDED, None)
            assert len(ended.result["filling"]) == 100_000

    asyncio.run(story())


def test_a_process_that_hangs_is_noticed_and_replaced(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, cancel_grace=GUARD) as (dispatcher, store):
            job = await dispatcher.submit(moving(tmp_path, silence=0.5))
            status = await eventually(lambda: store.last_event(job.id, "status"))
            os.kill(status.data["pid"], signal.SIGSTOP)
            ended = await dispatcher.wait(job.id, GUARD)
            assert ended.failure["code"] == "worker_unresponsive"
            assert ended.failure["evidence"] == {"silence": 0.5, "attempts": 1}
            after = await dispatcher.wait((await dispatcher.submit(spec("echo"))).id, GUARD)
            assert after.result["pid"] != status.data["pid"]

    asyncio.run(story())


def test_a_robot_that_hangs_on_its_way_to_rest_is_not_merely_canceled(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, cancel_grace=GUARD) as (dispatcher, store):
            job = await dispatcher.submit(moving(tmp_path, silence=0.5))
            status = await eventually(lambda: store.last_event(job.id, "status"))
            os.kill(status.data["pid"], signal.SIGSTOP)
            await dispatcher.cancel(job.id)
            ended = await dispatcher.wait(job.id, GUARD)
            assert ended.state is JobState.FAILED
            assert ended.failure["code"] == "worker_unresponsive"

    asyncio.run(story())


def test_a_server_that_stops_brings_what_moves_to_rest_first(tmp_path: Path) -> None:
    async def first() -> tuple[str, str]:
        async with running(tmp_path, cancel_grace=GUARD) as (dispatcher, store):
            job = await dispatcher.submit(moving(tmp_path))
            waits = await dispatcher.submit(moving(tmp_path))
            await eventually(lambda: store.last_event(job.id, "status"))
            return job.id, waits.id

    async def second(job: str, waits: str) -> None:
        async with running(tmp_path, cancel_grace=GUARD) as (dispatcher, store):
            ended = store.get(job)
            assert ended.state is JobState.CANCELED
            place = int((tmp_path / "rest").read_text())
            assert ended.failure["detail"] == f"at rest at {place}: the server stopped"
            assert ended.failure["evidence"] == {"place": place, "reason": "the server stopped"}
            assert store.get(waits).attempts <= 1
            await dispatcher.cancel(waits)

    asyncio.run(second(*asyncio.run(first())))


def test_who_waits_for_a_job_that_was_canceled_while_it_began_is_answered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The table never has it as begun; its worker may take long to get ready, or to be replaced."""

    async def story() -> None:
        async with running(tmp_path, cancel_grace=GUARD) as (dispatcher, store):
            written, write = asyncio.Event(), Attempt._write_start

            async def write_later(attempt: Attempt) -> object:
                await written.wait()
                return await write(attempt)

            gate = tmp_path / "gate"
            # A worker that is free has the start of a job written with the job itself.
            busy = await dispatcher.submit(spec("wait_for_file", payload={"file": str(gate)}))
            await eventually(lambda: store.last_event(busy.id, "stage"))
            monkeypatch.setattr(Attempt, "_write_start", write_later)
            job = await dispatcher.submit(spec("spin"))
            gate.touch()
            await eventually(lambda: dispatcher.attempt_of(job.id).has_begun)
            assert (await dispatcher.cancel(job.id)).state is JobState.CANCELED
            assert dispatcher.attempt_of(job.id) is not None
            ended = await asyncio.wait_for(dispatcher.wait(job.id, 1e6), GUARD / 4)
            assert ended.state is JobState.CANCELED
            written.set()

    asyncio.run(story())


def test_a_drain_lets_jobs_end_and_begins_none_and_robots_come_to_rest(tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, workers=2, cancel_grace=GUARD) as (dispatcher, store):
            files = {"file": str(tmp_path / "go"), "begun": str(tmp_path / "begun")}
            goes_on = await dispatcher.submit(spec("wait_for_file", payload=files))
            moves = await dispatcher.submit(moving(tmp_path))
            waits = await dispatcher.submit(spec("echo", key="k"))
            await eventually((tmp_path / "begun").exists)
            await eventually(lambda: store.last_event(moves.id, "status"))
            drained = asyncio.create_task(dispatcher.drain())
            await eventually(lambda: dispatcher.is_draining)
            with pytest.raises(ServerStopping):
                await dispatcher.submit(spec("echo"))
            assert (await dispatcher.submit(spec("echo", key="k"))).id == waits.id
            rests = await dispatcher.wait(moves.id, GUARD)
            assert rests.failure["evidence"]["reason"] == "the server stopped"
            call = Call("fake.echo", {}, "plan", GUARD, GUARD)
            assert (await dispatcher.call(call)).content["pid"] > 0
            assert not drained.done()
            assert store.get(goes_on.id).state is JobState.RUNNING
            (tmp_path / "go").touch()
            await asyncio.wait_for(drained, GUARD)
            assert store.get(goes_on.id).state is JobState.SUCCEEDED
            assert store.get(waits.id).state is JobState.QUEUED
            assert (await dispatcher.cancel(waits.id)).state is JobState.CANCELED

    asyncio.run(story())


def test_a_job_shows_the_versions_that_ran_it_and_no_others(tmp_path: Path) -> None:
    async def first() -> list[str]:
        async with running(tmp_path) as (dispatcher, _):
            jobs = [await dispatcher.submit(spec(task)) for task in ("echo", "refuse")]
            for job in jobs:
                assert job.made_by is None
                assert (await dispatcher.wait(job.id, GUARD)).made_by == {"tests": "1"}
            again = await dispatcher.submit(spec("spin"))
            await eventually(lambda: dispatcher.attempt_of(again.id).latest("stage"))
            return [*(job.id for job in jobs), again.id]

    async def second(good: str, bad: str, again: str) -> None:
        async with running(tmp_path, version="2") as (dispatcher, store):
            assert [store.get(job).made_by for job in (good, bad)] == [{"tests": "1"}] * 2
            await eventually(lambda: (run := dispatcher.attempt_of(again)) and run.latest("stage"))
            await dispatcher.cancel(again)
            assert (await dispatcher.wait(again, GUARD)).made_by == {"tests": "2"}
            made_by = [job.made_by["tests"] for job in store.page("plan")]
            assert made_by == ["2", "1", "1"]

    asyncio.run(second(*asyncio.run(first())))


def test_who_waits_is_answered_when_the_server_begins_to_end(tmp_path):
    """Not cut off: the job is accepted, and whoever asked for it has to know its id."""

    async def story():
        async with running(tmp_path) as (dispatcher, _):
            job = await dispatcher.submit(spec("spin"))
            waits = asyncio.create_task(dispatcher.wait(job.id, 1e6))
            await eventually(lambda: dispatcher.attempt_of(job.id).latest("stage"))
            assert not waits.done()
            dispatcher.begin_to_stop()
            answers = [await asyncio.wait_for(waits, GUARD), await dispatcher.wait(job.id, 1e6)]
            assert [answer.id for answer in answers] == [job.id] * 2

    asyncio.run(story())
