"""A database is brought to what the code has of it, from any revision; others are refused."""

import asyncio
import json
import re
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import MetaData, create_engine, text

from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.errors import DatabaseTooNew, DatabaseUnrecognized
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql import tables
from service.jobs.store.sql.database import open_engine
from service.jobs.store.sql.migrations.new_sqlite import STATEMENTS
from service.jobs.store.sql.migrations.snapshot import snapshot
from service.jobs.store.sql.migrations.upgrade import head, upgrade
from service.jobs.store.sql.schema import NEWEST, bring_up_to_date, stored_revision
from service.scenes.live import ExecutionSource, RobotStatus
from service.scenes.store import records
from service.scenes.store.live_rows import read_states
from service.security import keys
from service.webhooks import records as webhook_records
from tests.golden.service.stored import DUMP, load
from tests.service.jobs.databases import make_released
from tests.service.jobs.postgres import cluster

METADATA = (tables.metadata, records.metadata, keys.metadata, webhook_records.metadata)


@pytest.fixture
def engine(tmp_path):
    made = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    yield made
    made.dispose()


@pytest.fixture
def released(tmp_path):
    """A database as version 0.1 left it."""
    load(DUMP.read_text(encoding="utf-8"), tmp_path / "data")
    made = open_engine(f"sqlite:///{tmp_path / 'data' / 'wayproof.sqlite'}")
    yield made
    made.dispose()


def every_table():
    """All that the code reads and writes."""
    all_of_them = MetaData()
    for metadata in METADATA:
        for table in metadata.sorted_tables:
            table.to_metadata(all_of_them)
    return all_of_them


def assert_as_the_code_has_it(engine):
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), every_table()) == []


def definitions(engine):
    """What a SQLite database says that it was made by: the parts in the order of the alphabet."""
    query = "SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL AND name != :version"
    with engine.connect() as connection:
        found = connection.execute(text(query), {"version": "alembic_version"})
        return {name: parts_of(re.sub(r"\s+", " ", sql.replace('"', ""))) for name, sql in found}


def parts_of(sql):
    """What is made, and what it has between the brackets; columns that came later stand last."""
    begin, end = sql.index("("), sql.rindex(")")
    inner = re.split(r", (?![^()]*\))", sql[begin + 1 : end])
    return sql[:begin].strip(), sorted(part.strip() for part in inner), sql[end + 1 :].strip()


def rows(engine):
    """Returns all that the tables of a SQLite database have."""
    tables = "SELECT name FROM sqlite_master WHERE type = 'table'"
    with engine.connect() as connection:
        names = connection.execute(text(tables)).scalars().all()
        return {name: connection.execute(text(f'SELECT * FROM "{name}"')).all() for name in names}


def test_the_newest_revision_is_the_last_file():
    assert head() == NEWEST


def test_an_empty_database_gets_what_the_code_has(engine, tmp_path):
    bring_up_to_date(engine)
    assert stored_revision(engine) == NEWEST
    assert_as_the_code_has_it(engine)
    direct = create_engine(f"sqlite:///{tmp_path / 'direct.sqlite'}")
    for metadata in METADATA:
        metadata.create_all(direct)
    assert definitions(engine) == definitions(direct)
    direct.dispose()


def test_a_database_of_the_released_version_becomes_the_same(engine, released):
    bring_up_to_date(engine)
    assert stored_revision(released) is None
    bring_up_to_date(released)
    assert definitions(released) == definitions(engine)
    with released.connect() as connection:
        names = set(connection.execute(text("SELECT task FROM jobs")).scalars())
    assert names == {"plan", "reverse", "grow_regions", "execute"}


def test_where_an_execution_left_its_robot_is_kept_as_far_as_no_revision_says_it(released):
    """Version 0.1 made a revision of it when the scene was next looked at."""
    with released.begin() as connection:
        [(scene, job)] = connection.execute(
            text("SELECT scene, id FROM jobs WHERE lane = 'execution'")
        ).all()
        last = "SELECT data FROM job_events WHERE job = :job AND type = 'status' ORDER BY number"
        *_, status = connection.execute(text(last), {"job": job}).scalars()
        forget = "DELETE FROM scenes WHERE id = :scene AND revision = 3"
        assert connection.execute(text(forget), {"scene": scene}).rowcount == 1
    bring_up_to_date(released)
    with released.connect() as connection:
        [state] = read_states(connection, scene)
    measured = json.loads(status)["positions"]
    assert (state.robot, state.positions) == ("body", {"base_joint": measured})
    assert (state.source, state.ended) == (ExecutionSource(job), job)
    assert state.status is RobotStatus.AT_REST


def test_of_what_a_revision_says_nothing_is_kept_besides(released):
    bring_up_to_date(released)
    with released.connect() as connection:
        assert connection.execute(text("SELECT * FROM scene_states")).all() == []


def test_the_first_revision_is_what_was_released(engine, released):
    upgrade(engine, "0001")
    assert definitions(engine) == definitions(released)


def test_what_tests_take_for_the_released_version_is_it(engine, released):
    bring_up_to_date(engine)
    make_released(engine)
    assert definitions(engine) == definitions(released)


def test_a_table_that_an_older_version_lacked_is_made(released):
    with released.begin() as connection:
        for name in ("job_briefs", "job_owner"):
            connection.execute(text(f"DROP TABLE {name}"))
        connection.execute(text("DROP INDEX jobs_of_content"))
    bring_up_to_date(released)
    assert_as_the_code_has_it(released)
    with released.connect() as connection:
        counts = [
            connection.execute(text(f"SELECT count(*) FROM {name}")).scalar_one()
            for name in ("jobs", "job_summaries")
        ]
    assert counts[0] == counts[1] > 0


def test_tables_of_another_program_are_refused_and_left_alone(engine):
    with engine.begin() as connection:
        connection.execute(text("CREATE TABLE jobs (id INTEGER, title TEXT)"))
    before = definitions(engine)
    with pytest.raises(DatabaseUnrecognized) as refused:
        JobStore(engine).open()
    assert refused.value.evidence["table"] == "jobs"
    assert "serial" in refused.value.evidence["missing"]
    assert definitions(engine) == before
    assert stored_revision(engine) is None


def test_a_newer_database_is_refused_and_nothing_is_written(engine, tmp_path):
    bring_up_to_date(engine)
    newer = f"{int(NEWEST) + 1:04}"
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = :n"), {"n": newer})
    with pytest.raises(DatabaseTooNew) as refused:
        JobStore(engine).open()
    assert refused.value.evidence == {"revision": newer, "newest": NEWEST}
    dispatcher = Dispatcher(JobStore(engine), DispatcherLock(engine), {})
    with pytest.raises(DatabaseTooNew):
        asyncio.run(dispatcher.start())
    with closing(sqlite3.connect(tmp_path / "jobs.sqlite")) as other:
        assert other.execute("SELECT * FROM job_owner").fetchall() == []


def test_a_new_database_is_what_all_revisions_leave(engine, tmp_path):
    assert snapshot() == STATEMENTS, "python -m service.jobs.store.sql.migrations.snapshot"
    bring_up_to_date(engine)
    revised = create_engine(f"sqlite:///{tmp_path / 'revised.sqlite'}")
    upgrade(revised)
    assert definitions(engine) == definitions(revised)
    assert rows(engine) == rows(revised)
    assert any(rows(revised).values())
    revised.dispose()


def test_the_database_of_a_server_that_began_is_made_as_a_new_one(engine):
    lock = DispatcherLock(engine)
    lock.take()  # which makes the owner's table, before there are others
    bring_up_to_date(engine)
    assert stored_revision(engine) == NEWEST
    assert_as_the_code_has_it(engine)
    lock.release()


def test_databases_that_are_new_or_up_to_date_cost_no_import(engine, tmp_path):
    bring_up_to_date(engine)
    with closing(sqlite3.connect(tmp_path / "old.sqlite")) as old:
        old.execute("CREATE TABLE jobs (id TEXT)")
    code = "import sys; from service.jobs.store.sql.database import open_engine; "
    code += "from service.jobs.store.job_store import JobStore; "
    code += "store = JobStore(open_engine(sys.argv[1]))\ntry: store.open()\n"
    code += "finally: print('alembic' in sys.modules)"
    told = []
    for name in ("jobs.sqlite", "new.sqlite", "old.sqlite"):
        command = [sys.executable, "-c", code, f"sqlite:///{tmp_path / name}"]
        told.append(subprocess.run(command, capture_output=True, text=True, check=False).stdout)
    assert [said.strip() for said in told] == ["False", "False", "True"]


def test_two_that_open_a_new_database_at_once_make_it_once(engine, tmp_path):
    code = "import sys; from service.jobs.store.sql.database import open_engine; "
    code += "from service.jobs.store.job_store import JobStore; sys.stdin.read(); "
    code += "JobStore(open_engine(sys.argv[1])).open()"
    command = [sys.executable, "-c", code, f"sqlite:///{tmp_path / 'jobs.sqlite'}"]
    both = [subprocess.Popen(command, stdin=subprocess.PIPE) for _ in range(2)]
    for each in both:
        each.stdin.close()
    assert [each.wait(60) for each in both] == [0, 0]
    assert_as_the_code_has_it(engine)


def test_revisions_are_found_in_a_folder_of_any_name(tmp_path, engine, monkeypatch):
    from service.jobs.store.sql.migrations import upgrade as module

    odd = tmp_path / "50% of it"
    shutil.copytree(module._FOLDER, odd, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(module, "_FOLDER", odd)
    upgrade(engine)
    assert stored_revision(engine) == NEWEST


def test_postgresql_gets_the_same():
    with cluster() as server:
        engine = open_engine(server.url)
        upgrade(engine, "0001")
        bring_up_to_date(engine)
        assert stored_revision(engine) == NEWEST
        assert_as_the_code_has_it(engine)
        engine.dispose()
