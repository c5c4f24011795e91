"""Any number of servers work on one PostgreSQL database: one dispatches, all of them answer."""

import asyncio
import os
import signal
import subprocess
import sys
from collections import Counter

import pytest
from sqlalchemy import text

from planning.errors import IllegalTransition
from service.jobs.dispatch.leadership.leader import DispatcherLock, Vacancy
from service.jobs.errors import DatabaseInUse, IdempotencyConflict, QueueFull
from service.jobs.states import JobState
from service.jobs.store.sql.database import open_engine
from tests.profiles import only_campaign
from tests.service.jobs.conftest import GUARD, spec
from tests.service.jobs.dispatch.test_recovery import ROOT
from tests.service.jobs.several import quick, serving, two
from tests.service.jobs.test_stopping import eventually, moving
from tests.service.jobs.worker.test_process_worker import is_alive


async def pid_of(dispatcher, job):
    """The process that a job says it runs in."""
    async for event in dispatcher.subscribe(job.id):
        if "pid" in event.data:
            return event.data["pid"]
    return None


def test_a_job_from_a_follower_runs_at_the_leader_and_both_have_its_end(url):
    async def story():
        async with two(url) as (leader, follower):
            job = await follower.submit(spec("echo", payload={"x": 1}))
            assert follower.attempt_of(job.id) is None
            ended = await follower.wait(job.id, GUARD)
            assert ended.state is JobState.SUCCEEDED
            assert ended.result["echo"] == {"x": 1}
            assert await leader.wait(job.id, GUARD) == ended
            own = await leader.submit(spec("echo"))
            assert (await follower.wait_text(own.id, GUARD)).summary.state is JobState.SUCCEEDED
            call = await leader.submit(spec("refuse"))
            assert (await follower.wait(call.id, GUARD)).failure["code"] == "goal_unreachable"

    asyncio.run(story())


def test_events_of_a_run_elsewhere_are_streamed_each_once(url):
    async def story():
        async with two(url) as (leader, follower):
            job = await follower.submit(spec("chatter", payload={"count": 700, "size": 10}))
            streams = [follower.subscribe(job.id), leader.subscribe(job.id)]
            for events in streams:
                found = [event async for event in events]
                assert [event.number for event in found] == list(range(1, len(found) + 1))
                notes = [event.data["i"] for event in found if event.type == "note"]
                assert notes == list(range(700))
                assert found[-1].is_last

    asyncio.run(story())


def test_a_follower_cancels_what_hangs_in_native_code(url):
    """The leader, which waits for it, knows its end as well."""

    async def story():
        async with two(url) as (leader, follower):
            job = await leader.submit(spec("hang"))
            worker = await pid_of(follower, job)
            waits = asyncio.create_task(leader.wait(job.id, GUARD))
            begun = asyncio.get_running_loop().time()
            assert (await follower.cancel(job.id)).is_cancel_requested
            ended = await follower.wait(job.id, GUARD)
            seconds = asyncio.get_running_loop().time() - begun
            assert ended.state is JobState.CANCELED
            assert await waits == ended
            assert not is_alive(worker)
            assert seconds < GUARD / 4, "it came with the end of the sleep"

    asyncio.run(story())


def test_a_follower_cancels_what_waits_in_the_queue_of_the_leader(url):
    async def story():
        async with two(url) as (leader, follower):
            busy = await leader.submit(spec("spin"))
            await pid_of(leader, busy)
            waits = await leader.submit(spec("echo"))
            waiting = asyncio.create_task(leader.wait(waits.id, GUARD))
            assert (await follower.cancel(waits.id)).state is JobState.CANCELED
            assert (await waiting).state is JobState.CANCELED
            await eventually(lambda: leader.attempt_of(waits.id) is None)
            assert leader.loads()["plan"].num_waiting == 0
            await follower.cancel(busy.id)
            assert (await follower.wait(busy.id, GUARD)).state is JobState.CANCELED

    asyncio.run(story())


def test_a_follower_steers_a_run_and_both_keep_what_the_other_set(url, tmp_path):
    async def story():
        async with two(url) as (leader, follower):
            job = await follower.submit(moving(tmp_path))
            await pid_of(follower, job)
            run = leader.attempt_of(job.id)
            await follower.control(job.id, {"speed": 2})
            await eventually(lambda: run.latest("status")["asked"] == {"speed": 2})
            await leader.control(job.id, {"is_paused": True})
            both = {"speed": 2, "is_paused": True}
            await eventually(lambda: run.latest("status")["asked"] == both)
            await follower.control(job.id, {"is_paused": False})
            both = {"speed": 2, "is_paused": False}
            await eventually(lambda: run.latest("status")["asked"] == both)
            await follower.cancel(job.id)
            assert (await follower.wait(job.id, GUARD)).state is JobState.CANCELED
            with pytest.raises(IllegalTransition):
                await follower.control(job.id, {"speed": 3})

    asyncio.run(story())


def test_one_key_given_to_both_at_once_is_one_job(url, tmp_path):
    async def story():
        async with two(url) as dispatchers:
            file = tmp_path / "ran"
            for i in range(20):
                wanted = spec("touch", payload={"file": str(file)}, key=f"{i}", max_attempts=1)
                made = await asyncio.gather(*(each.submit(wanted) for each in dispatchers))
                assert len({job.id for job in made}) == 1
                for each in dispatchers:
                    assert (await each.wait(made[0].id, GUARD)).state is JobState.SUCCEEDED
                    with pytest.raises(IdempotencyConflict):
                        await each.submit(spec("warm", key=f"{i}", request_digest="other"))
            assert len(file.read_text().splitlines()) == 20

    asyncio.run(story())


def test_as_many_wait_as_may_wherever_they_came_from(url, tmp_path):
    async def story():
        async with two(url, max_waiting=10) as (leader, follower):
            gate = tmp_path / "gate"
            first = await leader.submit(spec("wait_for_file", payload={"file": str(gate)}))
            await pid_of(follower, first)
            wanted = [each.submit(spec("warm")) for each in (leader, follower) for _ in range(20)]
            made = await asyncio.gather(*wanted, return_exceptions=True)
            refused = [fault for fault in made if isinstance(fault, QueueFull)]
            assert len(refused) == 30
            assert all(fault.evidence["bound"] == 10 for fault in refused)
            gate.touch()
            for job in made:
                if not isinstance(job, QueueFull):
                    assert (await follower.wait(job.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


@only_campaign("27 s")
def test_a_thousand_jobs_from_both_end_once_each(url):
    async def story():
        async with two(url, inline=True, workers=4) as dispatchers:
            leader, follower = dispatchers
            wanted = [dispatchers[i % 2].submit(spec("warm", key=f"{i}")) for i in range(1000)]
            made = await asyncio.gather(*wanted)
            ended = await asyncio.gather(*(follower.wait(job.id, GUARD) for job in made))
            assert Counter(job.state for job in ended) == {JobState.SUCCEEDED: 1000}
            assert len({job.id for job in ended}) == 1000
            await eventually(lambda: not leader._attempts)
        engine = open_engine(url)
        ends = text("SELECT job, count(*) FROM job_events WHERE type = 'finished' GROUP BY job")
        starts = text("SELECT count(*) FROM job_events WHERE type = 'started'")
        with engine.connect() as connection:
            assert {number for _, number in connection.execute(ends)} == {1}
            assert connection.execute(starts).scalar_one() == 1000
        engine.dispose()

    asyncio.run(story())


def test_a_follower_leads_at_once_when_the_leader_stops(url, tmp_path):
    async def story():
        never = quick(patience=10 * GUARD)
        first = serving(url, timeouts=never)
        await first.__aenter__()
        async with serving(url, timeouts=never) as (second, store):
            gate = tmp_path / "gate"
            job = await second.submit(spec("wait_for_file", payload={"file": str(gate)}))
            await pid_of(second, job)
            waiting = asyncio.create_task(second.wait(job.id, GUARD))
            await first.__aexit__(None, None, None)
            await eventually(lambda: second.role == "leader")
            gate.touch()
            assert (await waiting).state is JobState.SUCCEEDED
            kinds = [event.type for event in await asyncio.to_thread(store.events, job.id)]
            assert kinds.count("requeued") == 1
            later = await second.submit(spec("warm"))
            assert (await second.wait(later.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


LEADER = """
import asyncio, sys
from pathlib import Path
from tests.service.jobs.conftest import spec
from tests.service.jobs.several import serving

async def main(url, folder):
    async with serving(url) as (dispatcher, store):
        gate = {"file": str(folder / "gate")}
        running = await dispatcher.submit(spec("wait_for_file", payload=gate))
        waits = [await dispatcher.submit(spec("touch", payload={"file": str(folder / f"{i}")}))
                 for i in range(10)]
        print(running.id, *(job.id for job in waits), flush=True)
        await asyncio.sleep(600)

if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], Path(sys.argv[2])))
"""


def test_a_follower_takes_over_from_a_leader_that_was_killed(url, tmp_path):
    """What ran runs again, what waited runs, nothing succeeds twice."""
    file = tmp_path / "leader.py"
    file.write_text(LEADER)

    async def story(process):
        line = await asyncio.to_thread(process.stdout.readline)
        running, *waiting = line.split()
        async with serving(url) as (follower, store):
            assert follower.role == "follower"
            async for event in follower.subscribe(running):
                if event.type == "started":
                    break
            ends = [asyncio.create_task(follower.wait(each, GUARD)) for each in (running, *waiting)]
            await asyncio.sleep(0)
            process.send_signal(signal.SIGKILL)
            await eventually(lambda: follower.role == "leader")
            (tmp_path / "gate").touch()
            ended = [await each for each in ends]
            assert {job.state for job in ended} == {JobState.SUCCEEDED}
            assert ended[0].attempts == 2
            for job in ended:
                events = await asyncio.to_thread(store.events, job.id)
                assert [event.number for event in events] == list(range(1, len(events) + 1))
                assert [event.type for event in events].count("finished") == 1
            assert all((tmp_path / f"{i}").read_text().count("\n") == 1 for i in range(10))

    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    options = {"stdout": subprocess.PIPE, "text": True, "env": environment}
    with subprocess.Popen([sys.executable, file, url, tmp_path], **options) as process:
        try:
            asyncio.run(story(process))
        finally:
            process.kill()


def test_a_restart_of_the_database_changes_no_role_and_is_listened_to_again(server, url):
    async def story():
        patient = quick(patience=GUARD, regain=GUARD)
        async with two(url, timeouts=patient) as (leader, follower):
            await asyncio.to_thread(server.stop)
            await asyncio.to_thread(server.start)
            await eventually(lambda: holds(url))
            assert (leader.role, follower.role) == ("leader", "follower")
            job = await follower.submit(spec("echo"))
            assert (await follower.wait(job.id, GUARD)).state is JobState.SUCCEEDED
            assert not leader.is_taken

    asyncio.run(story())


def holds(url):
    """Whether a server has the lock."""
    engine = open_engine(url)
    try:
        return DispatcherLock(engine).vacancy() is Vacancy.HELD
    finally:
        engine.dispose()


def test_what_no_notification_told_is_found_by_a_look(url):
    """One that another program put there, for example, or whose notification was lost."""

    async def story():
        looking = quick(patience=GUARD, poll=0.2)
        async with serving(url, timeouts=looking) as (leader, store):
            row, _ = await asyncio.to_thread(silently, store, spec("echo"))
            assert (await leader.wait(row.id, GUARD)).state is JobState.SUCCEEDED
            busy = await leader.submit(spec("spin"))
            await pid_of(leader, busy)
            await asyncio.to_thread(flag, store, busy.id)
            assert (await leader.wait(busy.id, GUARD)).state is JobState.CANCELED

    asyncio.run(story())


def silently(store, wanted):
    """Insert a job as its own server would, which it does not hear of."""
    return store.insert(wanted)


def flag(store, identifier):
    store.request_cancel(identifier)


def test_a_database_that_is_not_of_this_revision_has_no_followers(url):
    """A server of an older version works on it; it would not be brought up to date beneath it."""

    async def story():
        hasty = quick(patience=GUARD, tables=0.3)
        async with serving(url) as (_, store):
            await asyncio.to_thread(revise, store, "0002")
            with pytest.raises(DatabaseInUse, match="another version"):
                async with serving(url, timeouts=hasty):
                    pass

    asyncio.run(story())


def revise(store, revision):
    with store.transaction(is_durable=True) as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = :r"), {"r": revision})
