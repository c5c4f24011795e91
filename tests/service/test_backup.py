"""What was backed up is restored, in any folder; nothing else is, and not over records."""

import gzip
import json
import random
import sqlite3
import threading
from contextlib import closing
from datetime import UTC, datetime

import pytest
from typer.testing import CliRunner

from service import backup as module
from service.backup import BackupImpossible, BackupInvalid, RecordsExist, backup, restore
from service.cli.app import app
from service.jobs.artifacts import Artifact
from service.jobs.errors import DatabaseTooNew
from service.jobs.job import JobSpec
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.store.sql.schema import NEWEST, stored_revision
from service.security.keys import KeyStore, find_key
from service.security.scopes import Scope
from service.settings import Settings
from tests.golden.service.__main__ import changes
from tests.golden.service.answers import ask, client
from tests.golden.service.calls import get
from tests.golden.service.stored import ANSWERS, DUMP, load, read, settle


@pytest.fixture
def settings(tmp_path):
    return Settings(engine="inline", data_dir=tmp_path / "data", port=0)


@pytest.fixture
def elsewhere(tmp_path):
    return Settings(engine="inline", data_dir=tmp_path / "else" / "where", port=0)


@pytest.fixture
def file(tmp_path):
    (tmp_path / "kept").mkdir()
    return tmp_path / "kept" / "backup.sqlite.gz"


def store_at(settings):
    settings.data_dir.mkdir(parents=True, exist_ok=True)
    made = JobStore(open_engine(settings.url))
    made.open()
    return made


def keep(settings, content):
    """Have an artifact of a scene in the records."""
    return store_at(settings).artifacts.keep(Artifact(content), "world")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def rows(settings, query):
    with closing(sqlite3.connect(module._database_file(settings))) as database:
        return database.execute(query).fetchall()


def test_a_server_on_what_was_restored_elsewhere_answers_as_before(settings, elsewhere, file):
    stored = json.loads(ANSWERS.read_text(encoding="utf-8"))
    given = {name: {"id": identifier} for name, identifier in stored["ids"].items()}
    load(DUMP.read_text(encoding="utf-8"), settings.data_dir)
    with client(settings.data_dir) as service:
        settle(service, given)
    backup(settings, file)
    settings.data_dir.rename(settings.data_dir.with_name("gone"))
    restore(elsewhere, file)
    with client(elsewhere.data_dir) as service:
        assert changes(stored["answers"], read(service, given)) == []
        page = ask(service, get("", "/v1/plans/{done}/replay.html"), given)
        assert page.status_code == 200, page.text
    assert not settings.data_dir.exists()


def test_keys_are_restored_as_they_were_and_no_secret_is_in_the_file(settings, elsewhere, file):
    store_at(settings)
    keys, now = KeyStore(open_engine(settings.url)), datetime.now(UTC)
    good, gone = (keys.create(name, [Scope.PLAN], now) for name in ("good", "gone"))
    keys.revoke("gone", now)
    backup(settings, file)
    keys.revoke("good", now)
    restore(elsewhere, file)
    found = {key.id: key for key in KeyStore(open_engine(elsewhere.url)).all()}
    assert find_key(good.text, found) == good.key
    assert good.key.is_valid(now)
    assert not found[gone.key.id].is_valid(now)
    assert good.text[16:].encode() not in gzip.decompress(file.read_bytes())


def test_it_is_whole_while_jobs_are_written(settings, tmp_path, file):
    store, is_over = store_at(settings), threading.Event()

    def write():
        count = 0
        while not is_over.is_set():
            store.insert(JobSpec("plan", "plan", {"count": count, "x": "x" * 5000}))
            count += 1

    writer = threading.Thread(target=write)
    writer.start()
    counts = []
    try:
        for i in range(5):
            before = len(store.page("plan", limit=10_000))
            backup(settings, file)
            after = len(store.page("plan", limit=10_000))
            place = settings.model_copy(update={"data_dir": tmp_path / str(i)})
            restore(place, file)
            ((count,),) = rows(place, "SELECT count(*) FROM jobs")
            assert before <= count <= after
            counts.append(count)
            whole = "SELECT count(*) FROM jobs JOIN job_bodies ON job = id"
            assert rows(place, whole) == [(count,)]
            assert rows(place, "PRAGMA integrity_check") == [("ok",)]
            assert stored_revision(open_engine(place.url)) == NEWEST
    finally:
        is_over.set()
        writer.join()
    assert counts[-1] > 0


def test_what_an_older_version_left_is_not_backed_up_without_its_files(settings, file):
    load(DUMP.read_text(encoding="utf-8"), settings.data_dir)
    with pytest.raises(BackupImpossible, match="start the server of this version once"):
        backup(settings, file)
    assert not file.exists()


def test_records_are_not_replaced(settings, file):
    store = store_at(settings)
    backup(settings, file)
    job, _ = store.insert(JobSpec("plan", "plan", {}))
    with pytest.raises(RecordsExist):
        restore(settings, file)
    assert store.get(job.id) == job


def test_a_backup_that_fails_leaves_the_one_before(settings, file, monkeypatch):
    store_at(settings)
    backup(settings, file)
    before = file.read_bytes()

    def fail(*_):
        raise sqlite3.OperationalError("disk I/O error")

    monkeypatch.setattr(module, "_copy_database", fail)
    with pytest.raises(sqlite3.OperationalError):
        backup(settings, file)
    assert file.read_bytes() == before
    assert names(file.parent) == [file.name]


def assert_refused(settings, file, kind=BackupInvalid):
    with pytest.raises(kind) as refused:
        restore(settings, file)
    assert not (settings.data_dir / "wayproof.sqlite").exists()
    assert not any(path.is_file() for path in settings.data_dir.parent.rglob("*"))
    return refused.value


@pytest.mark.parametrize("place", [0, 0.1, 0.5, 0.9, 0.999])
def test_what_is_damaged_is_refused_whole(settings, elsewhere, file, place):
    keep(settings, random.Random(1).randbytes(4000))
    backup(settings, file)
    content = bytearray(file.read_bytes())
    at = int(place * len(content))
    content[at] ^= 0xFF
    file.write_bytes(content)
    assert_refused(elsewhere, file)
    file.write_bytes(content[:at])
    assert_refused(elsewhere, file)


def repacked(file, *statements):
    """Change the database in a backup."""
    plain = file.with_suffix(".plain")
    plain.write_bytes(gzip.decompress(file.read_bytes()))
    with closing(sqlite3.connect(plain)) as database:
        for statement in statements:
            database.execute(statement)
        database.commit()
    file.write_bytes(gzip.compress(plain.read_bytes()))
    plain.unlink()


def test_artifacts_are_what_they_are_named_for(settings, elsewhere, file):
    name = keep(settings, b"some")
    backup(settings, file)
    repacked(file, "UPDATE artifacts SET content = x'00'")
    assert assert_refused(elsewhere, file).evidence["member"] == f"artifact {name}"


@pytest.mark.parametrize("table", ["alembic_version", "artifacts"])
def test_what_lacks_a_table_is_refused(settings, elsewhere, file, table):
    store_at(settings)
    backup(settings, file)
    repacked(file, f"DROP TABLE {table}")
    assert_refused(elsewhere, file)


@pytest.mark.parametrize(
    "content", [b"", b"no archive", gzip.compress(b"no archive" * 99, mtime=0)]
)
def test_what_is_no_backup_is_refused(elsewhere, file, content):
    file.write_bytes(content)
    assert_refused(elsewhere, file)


def test_a_backup_of_a_newer_version_is_refused(settings, elsewhere, file):
    with store_at(settings)._engine.begin() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    assert backup(settings, file).revision == "9999"
    assert_refused(elsewhere, file, DatabaseTooNew)


def test_records_in_postgresql_are_left_to_its_own_tools(settings, file):
    url = {"database_url": "postgresql+psycopg://u:secret@nowhere/records"}
    for act in (backup, restore):
        with pytest.raises(BackupImpossible, match="pg_dump") as refused:
            act(settings.model_copy(update=url), file)
        assert "secret" not in json.dumps([refused.value.detail, refused.value.evidence])
    assert not file.exists()


def wayproof(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def test_the_commands_say_what_they_did(settings, elsewhere, file):
    store = store_at(settings)
    job, _ = store.insert(JobSpec("plan", "plan", {}))
    ended = wayproof("backup", file, "--data-dir", settings.data_dir)
    assert ended.exit_code == 0, ended.output
    assert f"wrote {file}" in ended.stdout
    ended = wayproof("restore", file, "--data-dir", elsewhere.data_dir)
    assert ended.exit_code == 0, ended.output
    assert JobStore(open_engine(elsewhere.url)).get(job.id) == job
    again = wayproof("restore", file, "--data-dir", elsewhere.data_dir)
    assert (again.exit_code, "there are records" in again.stderr) == (1, True)


def test_the_commands_say_what_is_missing(settings, file):
    ended = wayproof("backup", file, "--data-dir", settings.data_dir)
    assert (ended.exit_code, "there are no records" in ended.stderr) == (1, True)
    assert not file.exists()
    ended = wayproof("restore", file, "--data-dir", settings.data_dir)
    assert (ended.exit_code, str(file) in ended.stderr) == (1, True)
