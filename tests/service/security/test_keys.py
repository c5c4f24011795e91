"""Keys: made once, kept as digests, found by their id, expired, revoked and rotated."""

import re
from datetime import UTC, datetime, timedelta

import pytest
from sqlalchemy import text

from planning.errors import ProblemInvalid, UnknownName
from service.errors import KeyExists
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.errors import DatabaseInUse, DatabaseTooNew
from service.jobs.store.sql.database import open_engine
from service.jobs.store.sql.migrations.upgrade import upgrade
from service.jobs.store.sql.schema import NEWEST, stored_revision
from service.security.keys import KeyStore, find_key
from service.security.scopes import Scope
from tests.service.jobs.databases import make_released

NOW = datetime(2026, 1, 1, tzinfo=UTC)
HOUR = timedelta(hours=1)


@pytest.fixture
def engine(tmp_path):
    engine = open_engine(f"sqlite:///{tmp_path / 'keys.sqlite'}")
    yield engine
    engine.dispose()


@pytest.fixture
def store(engine):
    store = KeyStore(engine)
    store.open()
    return store


def find(store, text):
    return find_key(text, {key.id: key for key in store.all()})


def changed(text):
    """A key that differs in its last character."""
    return text[:-1] + ("A" if text[-1] != "A" else "B")


def test_a_key_is_found_by_its_text_and_by_no_other(store):
    one, other = store.create("a", [Scope.READ], NOW), store.create("b", [Scope.PLAN], NOW)
    assert find(store, one.text) == one.key
    assert find(store, other.text) == other.key
    swapped = one.text[:16] + other.text[16:]
    for wrong in (
        changed(one.text),
        swapped,
        one.text[:-1],
        one.text + "A",
        "",
        "wp_",
        f"{one.text}\n",
    ):
        assert find(store, wrong) is None, wrong


def test_the_secret_has_256_bits_and_is_never_the_same(store):
    texts = [store.create(f"k{i}", [Scope.READ], NOW).text for i in range(20)]
    secrets = {re.fullmatch(r"wp_[0-9a-f]{12}_([\w-]{43})", each)[1] for each in texts}
    assert len(secrets) == 20  # 43 letters of base64 are 256 bits


def test_the_database_and_reprs_have_no_secret(store, engine):
    new = store.create("a", [Scope.READ], NOW)
    secret = new.text.rsplit("_", 1)[-1] if new.text.count("_") == 2 else new.text[16:]
    with engine.connect() as connection:
        rows = str(connection.execute(text("select * from api_keys")).all())
    assert new.key.id in rows
    for shown in (rows, repr(new), repr(new.key), str(store.all())):
        assert secret not in shown
    assert new.key.digest not in repr(new.key)


def test_a_key_expires(store):
    key = store.create("a", [Scope.READ], NOW, NOW + HOUR).key
    assert key.is_valid(NOW)
    assert not key.is_valid(NOW + HOUR)
    assert store.create("b", [Scope.READ], NOW).key.is_valid(NOW + 10**5 * HOUR)


def test_a_name_has_one_valid_key(store):
    store.create("a", [Scope.READ], NOW, NOW + HOUR)
    with pytest.raises(KeyExists, match="rotate a"):
        store.create("a", [Scope.READ], NOW)
    assert store.create("a", [Scope.READ], NOW + HOUR).key.name == "a"


def test_a_name_is_never_the_id_of_another(store):
    key = store.create("a", [Scope.READ], NOW).key
    with pytest.raises(ProblemInvalid, match="1 to 64"):
        store.create(key.id, [Scope.READ], NOW)


def test_a_row_that_is_none_is_no_key_and_hides_no_other(store, engine, caplog):
    """What cannot be read would have the keys read before it hold without end."""
    kept = store.create("a", [Scope.READ], NOW).key
    for name, change in (
        ("b", "scopes = 'read,everything'"),
        ("c", "expires_at = 'tomorrow'"),
        ("d", "scopes = ''"),
    ):
        store.create(name, [Scope.READ], NOW)
        with engine.begin() as connection:
            connection.execute(text(f"UPDATE api_keys SET {change} WHERE name = '{name}'"))
    assert store.all() == store.all() == [kept]  # once a second, and told of once
    assert caplog.text.count("is no key") == 3


@pytest.mark.parametrize("revision", ["0001", "0003"])
def test_an_old_database_is_changed_only_while_no_server_works_on_it(engine, store, revision):
    make_released(engine)
    upgrade(engine, revision)
    lock = DispatcherLock(engine)
    lock.take()
    with pytest.raises(DatabaseInUse):
        KeyStore(engine).open()
    assert stored_revision(engine) == revision
    lock.release()
    KeyStore(engine).open()
    assert stored_revision(engine) == NEWEST
    assert store.create("a", [Scope.READ], NOW).key in store.all()


def test_to_open_it_is_no_start_of_a_server(engine, store):
    """A server that takes over has to know whether the one before it had ended in order."""
    crashed = DispatcherLock(engine)
    crashed.take()
    crashed._unlock()
    make_released(engine)
    KeyStore(engine).open()
    following = DispatcherLock(engine)
    following.take()
    assert (following.epoch, following.was_left) == (crashed.epoch + 1, True)
    following.release()


def test_a_server_at_work_is_no_hindrance(engine, store):
    lock = DispatcherLock(engine)
    lock.take()
    KeyStore(engine).open()
    assert store.create("a", [Scope.READ], NOW).key in store.all()
    lock.release()


def test_a_newer_database_is_refused(engine, store):
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(DatabaseTooNew):
        KeyStore(engine).open()


@pytest.mark.parametrize("name", ["", "a b", "x" * 65, "ä", "a\n"])
def test_names_that_logs_cannot_hold_are_refused(store, name):
    with pytest.raises(ProblemInvalid, match="1 to 64"):
        store.create(name, [Scope.READ], NOW)


def test_a_key_has_a_scope(store):
    with pytest.raises(ProblemInvalid, match="needs a scope"):
        store.create("a", [], NOW)


def test_revoked_keys_are_refused_and_stay_on_the_list(store):
    store.create("a", [Scope.READ], NOW)
    kept = store.create("b", [Scope.READ], NOW)
    (gone,) = store.revoke("a", NOW + HOUR)
    by_name = {key.name: key for key in store.all()}
    assert gone.id == by_name["a"].id
    assert not by_name["a"].is_valid(NOW + HOUR)
    assert by_name["b"].is_valid(NOW + HOUR)
    assert store.revoke(kept.key.id, NOW)[0].name == "b"
    with pytest.raises(UnknownName, match="'a' does not exist"):
        store.revoke("a", NOW + HOUR)


@pytest.mark.parametrize(("overlap", "is_old_good"), [(timedelta(0), False), (HOUR, True)])
def test_rotation_keeps_scopes_and_lifetime(store, overlap, is_old_good):
    old = store.create("a", [Scope.READ, Scope.EXECUTE], NOW, NOW + 10 * HOUR)
    new = store.rotate("a", NOW + HOUR, overlap)
    assert new.key.name == "a"
    assert new.key.scopes == old.key.scopes
    assert new.key.expires_at == NOW + 11 * HOUR
    assert find(store, new.text).is_valid(NOW + HOUR)
    found = find(store, old.text)
    assert found.is_valid(NOW + HOUR) is is_old_good
    assert not found.is_valid(NOW + HOUR + overlap)


def test_an_overlap_lengthens_no_life(store):
    old = store.create("a", [Scope.READ], NOW, NOW + HOUR)
    store.rotate("a", NOW, 10 * HOUR)
    assert find(store, old.text).expires_at == NOW + HOUR


@pytest.mark.parametrize("scope", Scope)
def test_admin_is_all_scopes_and_each_other_one_is_itself(store, scope):
    own = store.create("a", [scope], NOW).key
    expected = set(Scope) if scope is Scope.ADMIN else {scope}
    assert {each for each in Scope if own.allows(each)} == expected
