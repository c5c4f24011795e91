"""The same store on PostgreSQL, which may end, and whose lock may be lost and not be noticed."""

import asyncio
import threading
from contextlib import asynccontextmanager, contextmanager

import pytest
from sqlalchemy import text

from service.cli.server import TAKEN
from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.errors import DatabaseInUse, DatabaseTaken, IdempotencyConflict
from service.jobs.json_text import Encoded, encode
from service.jobs.states import JobState
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.worker.process_worker import ProcessWorker
from tests.profiles import only_campaign
from tests.service.jobs.conftest import GUARD, TASKS, WARM_UP, spec
from tests.service.jobs.one_at_a_time import NUM_SERVERS, check_one_at_a_time
from tests.service.jobs.test_briefs import check_upgrade
from tests.service.jobs.test_stopping import eventually, moving
from tests.service.servers import server as real_server
from tests.service.servers import until

# Nothing is noticed by looking at the lock.
BLIND = DatabaseTimeouts(period=10 * GUARD)
QUICK = DatabaseTimeouts(period=0.05, answer=GUARD, regain=GUARD, rest=0.0)
HASTY = DatabaseTimeouts(period=0.05, answer=GUARD, regain=0.2, rest=0.0)


class Soon(DatabaseTimeouts):
    """Takes up soon what another has left."""

    takeover = 2.0


# All backends that hold an advisory lock end.
END_OWNER = text("SELECT pg_terminate_backend(pid) FROM pg_locks WHERE locktype = 'advisory'")


@asynccontextmanager
async def serving(url, timeouts=None):
    """A dispatcher with an execution-like queue, its store, and its engine."""
    engine = open_engine(url)
    store = JobStore(engine)
    queues = {"plan": JobQueue("plan", [ProcessWorker([TASKS])], 100, cancel_grace=GUARD)}
    taken = threading.Event()
    dispatcher = Dispatcher(
        store, DispatcherLock(engine), queues, on_taken=taken.set, timeouts=timeouts
    )
    await dispatcher.start(WARM_UP)
    try:
        yield dispatcher, store
    finally:
        await dispatcher.stop()
        engine.dispose()
        assert taken.is_set() is dispatcher.is_taken


@contextmanager
def closing_engine(url):
    engine = open_engine(url)
    try:
        yield engine
    finally:
        engine.dispose()


async def moves(dispatcher, folder):
    """A job that moves, and how it goes."""
    job = await dispatcher.submit(moving(folder))
    live = dispatcher.attempt_of(job.id)
    await eventually(lambda: live.latest("status"))
    return job, live


def place(live):
    return live.latest("status")["place"]


async def run_jobs(engine):
    """Jobs, a crash, a cancel, events, keys and a rival, on one database."""
    store = JobStore(engine)
    queues = {"plan": JobQueue("plan", [ProcessWorker([TASKS])], 100)}
    dispatcher = Dispatcher(store, DispatcherLock(engine), queues)
    await dispatcher.start(WARM_UP)
    try:
        good = await dispatcher.submit(
            spec("vast", payload={"count": 1000}, key="k", request_digest="1")
        )
        dead = await dispatcher.submit(spec("segfault"))
        assert (await dispatcher.submit(spec("vast", key="k", request_digest="1"))).id == good.id
        with pytest.raises(IdempotencyConflict):
            await dispatcher.submit(spec("vast", key="k", request_digest="2"))
        numbers = (await dispatcher.wait(good.id, GUARD)).result["numbers"]
        assert numbers == [0.1 * i for i in range(1000)]
        assert (await dispatcher.wait(dead.id, GUARD)).failure["code"] == "worker_crashed"
        busy = await dispatcher.submit(spec("spin"))
        async for event in dispatcher.subscribe(busy.id):
            if "pid" in event.data:
                break
        await dispatcher.cancel(busy.id)
        assert (await dispatcher.wait(busy.id, GUARD)).state == "canceled"
        assert [event.number for event in store.events(dead.id)] == [1, 2, 3, 4, 5]
        assert [job.id for job in store.page("plan", limit=2)] == [busy.id, dead.id]
        assert store.counts()["plan", "failed"] == 1
        rival = open_engine(str(engine.url.render_as_string(hide_password=False)))
        with pytest.raises(DatabaseInUse):
            DispatcherLock(rival).take()
        rival.dispose()
    finally:
        await dispatcher.stop()
    ownership = DispatcherLock(engine)
    ownership.take()
    ownership.release()


def test_jobs_on_postgresql(url):
    engine = open_engine(url)
    try:
        asyncio.run(run_jobs(engine))
        store = JobStore(engine)
        odd, _ = store.insert(spec("x", payload={"text": "\0 \ud800 \u2028", "n": float("nan")}))
        assert store.get(odd.id).payload == {"text": "\0 \ud800 \u2028", "n": None}
    finally:
        engine.dispose()


def test_a_database_of_version_0_1_is_brought_up_to_date_on_postgresql(url):
    engine = open_engine(url)
    try:
        check_upgrade(engine)
    finally:
        engine.dispose()


def test_one_execution_of_a_scene_is_open_at_most(url):
    engines = [open_engine(url) for _ in range(NUM_SERVERS)]
    check_one_at_a_time(engines)
    for engine in engines:
        engine.dispose()


@pytest.mark.parametrize("level", ["on", "off"])
def test_what_was_told_outlives_the_end_of_the_database_alone(server, url, level):
    with default_level(url, level), closing_engine(url) as engine:
        store = JobStore(engine)
        store.open()
        job, _ = store.insert(spec("x"))
        told = store.events(job.id)
        started = store.start(job.id)
        assert started is not None
        told.append(started.event)
        for place in range(5):
            status = store.append_events(job.id, [("status", Encoded(encode({"place": place})))])
            assert len(status) == 1
            told += status
            server.stop()
            server.start()
            assert store.events(job.id) == told


@contextmanager
def default_level(url, level):
    """What connections are told to wait for, unless they say otherwise."""
    change = "ALTER ROLE wp {} synchronous_commit{}".format
    with closing_engine(url) as engine:
        connection = engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        connection.exec_driver_sql(change("SET", f" = {level}"))
        connection.close()
    yield
    with closing_engine(url) as engine:
        connection = engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        connection.exec_driver_sql(change("RESET", ""))
        connection.close()


def test_a_restart_of_the_database_stops_nothing_and_lets_no_other_in(server, url, tmp_path):
    async def story():
        async with serving(url, QUICK) as (dispatcher, store):
            job, live = await moves(dispatcher, tmp_path)
            await asyncio.to_thread(server.stop)
            stopped = place(live)
            await eventually(lambda: place(live) > stopped)
            await asyncio.to_thread(server.start)
            rival = open_engine(url)
            await eventually(lambda: has_owner(rival))
            with pytest.raises(DatabaseInUse):
                await asyncio.to_thread(DispatcherLock(rival).take)
            rival.dispose()
            before = place(live)
            await eventually(lambda: place(live) > before)
            await dispatcher.cancel(job.id)
            assert (await dispatcher.wait(job.id, GUARD)).state is JobState.CANCELED
            numbers = [event.number for event in store.events(job.id)]
            assert numbers == list(range(1, len(numbers) + 1))

    asyncio.run(story())


def has_owner(engine):
    """Whether the lock is held: the owner took it again."""
    held = text("SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND granted")
    with engine.connect() as connection:
        return connection.execute(held).scalar_one() == 1


def test_two_servers_never_run_one_job(url, tmp_path):
    """The first does not even look at its lock: its writes are refused, and so it knows."""

    async def story():
        async with serving(url, BLIND) as (first, store):
            job, _ = await moves(first, tmp_path)
            later = await first.submit(spec("echo"))
            await asyncio.to_thread(end_owner, url)
            async with serving(url, Soon(period=10 * GUARD)) as (second, records):
                # It is taken up only once the first one must have come to rest.
                assert records.get(job.id).state is JobState.RUNNING
                await eventually((tmp_path / "rest").exists)
                await eventually(lambda: first.is_taken)
                with pytest.raises(DatabaseTaken):
                    store.request_cancel(job.id)
                ended = await second.wait(job.id, GUARD)
                assert ended.failure["code"] == "server_restarted"
                assert (await second.wait(later.id, GUARD)).state is JobState.SUCCEEDED
                assert not records.unfinished()

    asyncio.run(story())


def end_owner(url):
    engine = open_engine(url)
    with engine.begin() as connection:
        connection.execute(END_OWNER)
    engine.dispose()


def test_one_who_looks_at_a_lock_that_another_has_gives_up(url, tmp_path):
    """Its job says nothing, so that nothing is written that could be refused."""

    async def story():
        async with serving(url, QUICK) as (dispatcher, _):
            job = await dispatcher.submit(spec("spin", max_attempts=1))
            live = dispatcher.attempt_of(job.id)
            await eventually(lambda: live.latest("stage"))
            await eventually(lambda: not live.unrecorded)
            with taken_by_force(url) as rival:
                await asyncio.wait_for(live.concluded.wait(), GUARD)
                assert dispatcher.is_taken
                state = text("SELECT state FROM jobs WHERE id = :id")
                assert rival.execute(state, {"id": job.id}).scalar_one() == "running"

    asyncio.run(story())


@contextmanager
def taken_by_force(url):
    """Wait in line for the lock, end its owner, and count the epoch up; yields a connection."""
    engine = open_engine(url)
    waits, other = (
        engine.connect().execution_options(isolation_level="AUTOCOMMIT") for _ in range(2)
    )
    take = text("SELECT pg_advisory_lock(:key)"), {"key": 0x57_61_79_70}
    lock = threading.Thread(target=waits.execute, args=take)
    lock.start()
    try:
        in_line = text("SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND NOT granted")
        until(lambda: other.execute(in_line).scalar_one())
        other.execute(text(f"{END_OWNER} AND granted"))
        lock.join(GUARD)
        other.execute(text("UPDATE job_owner SET epoch = epoch + 1"))
        yield other
    finally:
        for connection in (waits, other):
            connection.invalidate()
            connection.close()
        engine.dispose()


def test_what_moves_comes_to_rest_if_the_database_stays_away(server, url, tmp_path):
    async def story():
        async with serving(url, HASTY) as (dispatcher, _):
            job, live = await moves(dispatcher, tmp_path)
            waits = await dispatcher.submit(spec("echo"))
            await asyncio.to_thread(server.stop)
            await eventually((tmp_path / "rest").exists)
            await eventually(lambda: "end" in live.unrecorded)
            await asyncio.to_thread(server.start)
            await asyncio.wait_for(live.concluded.wait(), GUARD)
            ended = await dispatcher.wait(job.id, GUARD)
            assert ended.state is JobState.CANCELED
            assert ended.failure["evidence"]["reason"] == "the database was out of reach"
            assert (await dispatcher.wait(waits.id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())


@only_campaign("9 s")
def test_a_server_that_has_lost_its_database_ends(url, tmp_path):
    on_postgres = {"WAYPROOF_DATABASE_URL": url, "WAYPROOF_ENGINE": "inline"}  # it runs nothing
    with real_server(tmp_path, **on_postgres) as lost, taken_by_force(url):
        assert lost.process.wait(GUARD) == TAKEN
