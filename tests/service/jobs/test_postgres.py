"""The same store on PostgreSQL: on a server of our own where there is one, else its dialect."""

import asyncio
import importlib.util
import os
import pwd
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest
from sqlalchemy.dialects import postgresql
from sqlalchemy.schema import CreateTable

from service.jobs.database import open_engine
from service.jobs.dispatcher import Dispatcher
from service.jobs.errors import DatabaseInUse, IdempotencyConflict
from service.jobs.lane import Lane
from service.jobs.ownership import Ownership
from service.jobs.records import metadata
from service.jobs.slot import ProcessSlot
from service.jobs.store import JobStore
from tests.service.jobs.conftest import GUARD, TASKS, spec
from tests.service.jobs.test_briefs import check_upgrade


def binaries():
    """The folder of a PostgreSQL server's programs, None if there is no server."""
    found = shutil.which("initdb")
    folders = [Path(found).resolve().parent] if found else []
    folders += sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    return next((f for f in folders if (f / "pg_ctl").is_file()), None)


HAS_SERVER = binaries() is not None and importlib.util.find_spec("psycopg") is not None


def demoted():
    """How to run a program that refuses to be root."""
    if os.getuid() != 0:
        return {}
    names = [entry.pw_name for entry in pwd.getpwall()]
    user = pwd.getpwnam("postgres" if "postgres" in names else "nobody")
    return {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}


@contextmanager
def cluster():
    """A server on a Unix socket in a folder of its own; its URL."""
    with tempfile.TemporaryDirectory(prefix="wp-pg-", ignore_cleanup_errors=True) as name:
        folder, who = Path(name), demoted()
        if who:
            os.chown(folder, who["user"], who["group"])
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder, **who}
        init = [binaries() / "initdb", "-D", folder / "data", "-A", "trust", "-U", "wp", "-N"]
        subprocess.run(init, check=True, **quiet)
        options = f"-k {folder} -c listen_addresses= -c fsync=off"
        control = [binaries() / "pg_ctl", "-D", folder / "data", "-w"]
        subprocess.run([*control, "-o", options, "start"], check=True, **quiet)
        try:
            yield f"postgresql+psycopg://wp@/postgres?host={folder}"
        finally:
            subprocess.run([*control, "-m", "immediate", "stop"], check=True, **quiet)


async def run_jobs(engine):
    """Jobs, a crash, a cancel, events, keys and a rival, on one database."""
    store = JobStore(engine)
    lanes = {"plan": Lane("plan", [ProcessSlot([TASKS])], 100)}
    dispatcher = Dispatcher(store, Ownership(engine), lanes)
    await dispatcher.start(f"{TASKS}:warm")
    try:
        good = await dispatcher.submit(spec("vast", payload={"count": 1000}, key="k", request_digest="1"))
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
            Ownership(rival).take()
        rival.dispose()
    finally:
        await dispatcher.stop()
    ownership = Ownership(engine)
    ownership.take()
    ownership.release()


def check_server():
    with cluster() as url:
        engine = open_engine(url)
        try:
            asyncio.run(run_jobs(engine))
            store = JobStore(engine)
            odd, _ = store.insert(
                spec("x", payload={"text": "\0 \ud800 \u2028", "n": float("nan")})
            )
            assert store.get(odd.id).payload == {"text": "\0 \ud800 \u2028", "n": None}
            check_upgrade(engine)
        finally:
            engine.dispose()


def check_dialect():
    """Without a server: the tables can be declared there, and the identity column counts."""
    dialect = postgresql.dialect()
    declared = {
        t.name: str(CreateTable(t).compile(dialect=dialect)) for t in metadata.sorted_tables
    }
    assert "serial BIGSERIAL" in declared["jobs"]
    assert "data TEXT NOT NULL" in declared["job_events"]


def test_jobs_on_postgresql():
    """The whole engine, if this machine has a server and a driver; else what can be said."""
    check_dialect()
    if HAS_SERVER:
        check_server()
