"""One contract for jobs, wherever their workers are and whichever database has them.

`make test` looks at this machine, and at hosts in this process that get what crosses the network as
bytes; `make ray` looks at machines of a Ray cluster.
"""

import asyncio
import hashlib
import os
import signal
from itertools import product
from pathlib import Path

import pytest
from sqlalchemy import text

from planning.errors import DeadlineExceeded, GoalUnreachable
from service.jobs.dispatch.calls import Call
from service.jobs.states import JobState
from service.jobs.store.sql.database import open_engine
from tests.profiles import pairs
from tests.service.jobs.conftest import GUARD, running, spec
from tests.service.jobs.dispatch.test_dispatcher import until_running
from tests.service.jobs.postgres import cluster as database_cluster
from tests.service.jobs.prompt_loop import only_short_waits
from tests.service.jobs.prompt_loop import run as run_promptly
from tests.service.jobs.remote.machines import KINDS, REMOTE, Site
from tests.service.jobs.test_stopping import eventually, moving
from tests.service.jobs.worker.test_process_worker import is_alive

DATABASES = ("sqlite", "postgresql")
# A canceled job ends within that, whatever it does; the rest is the machine's [s].
PROMPT = 1.0
# Of the machines that hosts are on, each is seen with each database by `make ray`.
PLACES = product(KINDS, DATABASES) if KINDS == ("ray",) else pairs(KINDS, DATABASES)


@pytest.fixture(scope="module")
def database():
    with database_cluster() as made:
        yield made


@pytest.fixture
def url_of(request):
    """The address of an empty database of a kind."""

    def found(kind):
        if kind == "sqlite":
            return None
        url = request.getfixturevalue("database").url
        engine = open_engine(url)
        with engine.begin() as connection:
            connection.execute(text("DROP SCHEMA public CASCADE"))
            connection.execute(text("CREATE SCHEMA public"))
        engine.dispose()
        return url

    return found


@pytest.fixture(params=PLACES, ids="-".join)
def site(request, url_of) -> Site:
    """Where workers and records are."""
    kind, database = request.param
    return Site(kind, url_of(database))


@pytest.fixture(params=REMOTE)
def two_hosts(request) -> Site:
    """Two machines, each with a worker."""
    return Site(request.param, hosts=2)


def test_a_crash_is_tried_again_and_then_told(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, store):
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


def test_a_worker_killed_from_outside_loses_nothing(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, store):
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


def test_a_deadline_ends_native_code(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, _):
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


async def waited_for(dispatcher, job):
    """A task that returns the job once it has ended; what bounds it is set from now on."""
    end = asyncio.create_task(dispatcher.wait(job.id, GUARD))
    await asyncio.sleep(0)
    return end


@pytest.mark.parametrize("task", ["spin", "hang"])
def test_cancel_works_in_every_state_and_again(site: Site, tmp_path: Path, task: str) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, store):
            busy = await dispatcher.submit(spec(task))
            waiting = await dispatcher.submit(spec("echo"))
            await until_running(dispatcher, store, busy)
            end = await waited_for(dispatcher, busy)
            with only_short_waits(PROMPT):
                assert (await dispatcher.cancel(waiting.id)).state is JobState.CANCELED
                await dispatcher.cancel(busy.id)
                await dispatcher.cancel(busy.id)
                ended = await end
            assert ended.state is JobState.CANCELED
            assert ended.failure["code"] == "canceled"
            assert (await dispatcher.cancel(busy.id)).state is JobState.CANCELED
            assert [e.type for e in store.events(waiting.id)] == ["queued", "finished"]
            after = await dispatcher.submit(spec("echo"))
            assert (await dispatcher.wait(after.id, GUARD)).state is JobState.SUCCEEDED
            assert (await dispatcher.cancel(after.id)).state is JobState.SUCCEEDED

    run_promptly(story())


def test_a_cancel_right_at_the_start_is_not_missed(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, _):
            for _ in range(5):
                job = await dispatcher.submit(spec("spin"))
                end = await waited_for(dispatcher, job)
                await asyncio.sleep(0.001)
                with only_short_waits(PROMPT):
                    await dispatcher.cancel(job.id)
                    assert (await end).state is JobState.CANCELED

    run_promptly(story())


def test_events_are_numbered_without_gaps_and_replayed(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, store):
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


def asked(task: str, payload: dict | None = None, allowed: float = GUARD) -> Call:
    return Call(f"fake.{task}", payload or {}, "plan", allowed, GUARD)


def test_short_calls_return_raise_and_time_out(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, _):
            answer = await dispatcher.call(asked("echo", {"b": 2}))
            assert answer.content["echo"] == {"b": 2}
            with pytest.raises(GoalUnreachable, match="too far"):
                await dispatcher.call(asked("refuse"))
            with pytest.raises(DeadlineExceeded):
                await dispatcher.call(asked("hang", allowed=0.5))

    asyncio.run(story())


def test_controls_reach_a_run_and_it_obeys(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, _):
            job = await dispatcher.submit(moving(tmp_path))
            live = dispatcher.attempt_of(job.id)
            await eventually(lambda: live.latest("status"))
            await dispatcher.control(job.id, {"a": 1})
            await dispatcher.control(job.id, {"b": 2})
            await eventually(lambda: live.latest("status")["asked"] == {"a": 1, "b": 2})
            goal = live.latest("status")["place"] + 50
            await dispatcher.control(job.id, {"goal": goal})
            assert (await dispatcher.wait(job.id, GUARD)).result == {"place": goal}

    asyncio.run(story())


def test_what_moves_comes_to_rest_when_it_is_canceled(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, cancel_grace=GUARD, site=site) as (dispatcher, _):
            job = await dispatcher.submit(moving(tmp_path))
            await eventually(lambda: dispatcher.attempt_of(job.id).latest("status"))
            await dispatcher.cancel(job.id)
            ended = await dispatcher.wait(job.id, GUARD)
            assert ended.state is JobState.CANCELED
            assert ended.failure["evidence"] == {"place": int((tmp_path / "rest").read_text())}

    asyncio.run(story())


def test_results_are_the_same_to_the_last_bit(site: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=site) as (dispatcher, _):
            job = await dispatcher.submit(spec("vast", payload={"count": 100_000}))
            numbers = (await dispatcher.wait(job.id, GUARD)).result["numbers"]
            digests = [
                hashlib.sha256(repr(each).encode()).hexdigest()
                for each in (numbers, [0.1 * i for i in range(100_000)])
            ]
            assert digests[0] == digests[1]

    asyncio.run(story())


async def host_of(dispatcher, job, besides=""):
    """The machine on which a job runs, once it does, and not on a certain one."""

    def found():
        run = dispatcher.attempt_of(job.id)
        worker = run and run.latest("stage") and run._worker
        return worker and worker._name != besides and worker._name

    return await eventually(found)


def test_a_job_of_a_lost_machine_runs_again_on_another_one(two_hosts: Site, tmp_path: Path) -> None:
    """That is no attempt of its own: one crash after it is still forgiven."""

    async def story() -> None:
        async with running(tmp_path, site=two_hosts) as (dispatcher, store):
            job = await dispatcher.submit(spec("spin"))
            first = await host_of(dispatcher, job)
            pid = dispatcher.attempt_of(job.id).latest("stage")["pid"]
            await two_hosts.lose(first)
            await host_of(dispatcher, job, besides=first)
            await eventually(lambda: not is_alive(pid))
            seen = store.events(job.id)
            (again,) = [event for event in seen if event.type == "requeued"]
            assert again.data["reason"] == f"the machine {first} was lost"
            os.kill(dispatcher.attempt_of(job.id).latest("stage")["pid"], signal.SIGKILL)
            await eventually(lambda: store.get(job.id).attempts == 2)
            await dispatcher.cancel(job.id)
            assert (await dispatcher.wait(job.id, GUARD)).state is JobState.CANCELED

    asyncio.run(story())


def test_what_may_run_but_once_fails_with_its_machine(two_hosts: Site, tmp_path: Path) -> None:
    async def story() -> None:
        async with running(tmp_path, site=two_hosts) as (dispatcher, _):
            job = await dispatcher.submit(spec("spin", max_attempts=1))
            host = await host_of(dispatcher, job)
            await two_hosts.lose(host)
            ended = await dispatcher.wait(job.id, GUARD)
            assert ended.failure["code"] == "host_lost"
            assert ended.failure["evidence"] == {"attempts": 1, "host": host, "during": "spin"}
            after = await dispatcher.submit(spec("echo"))
            assert (await dispatcher.wait(after.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


def test_a_machine_that_is_lost_while_idle_gets_nothing_to_do(
    two_hosts: Site, tmp_path: Path
) -> None:
    """Not even what may run but once fails, for it has not begun there."""

    async def story() -> None:
        async with running(tmp_path, site=two_hosts) as (dispatcher, _):
            await eventually(lambda: dispatcher.loads()["plan"].num_ready == 2)
            first = await dispatcher.submit(spec("spin"))
            host = await host_of(dispatcher, first)
            await dispatcher.cancel(first.id)
            await dispatcher.wait(first.id, GUARD)
            await two_hosts.lose(host)
            await eventually(lambda: dispatcher.loads()["plan"].num_ready == 1)
            for _ in range(3):
                job = await dispatcher.submit(spec("echo", max_attempts=1))
                assert (await dispatcher.wait(job.id, GUARD)).state is JobState.SUCCEEDED
            answer = await dispatcher.call(asked("echo", {"b": 2}))
            assert answer.content["echo"] == {"b": 2}

    asyncio.run(story())
