"""Scenes survive the server; their files can be lost."""

import asyncio
import json
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from inspect import iscoroutinefunction

import pytest
from anyio.from_thread import start_blocking_portal
from sqlalchemy import create_engine, event, insert, select
from sqlalchemy.exc import DBAPIError

from service.errors import RevisionConflict, UnknownResource
from service.jobs.artifacts import Artifact
from service.jobs.job import JobSpec
from service.jobs.json_text import Encoded, encode, encode_in_parts
from service.jobs.store.artifact_store import ArtifactStore, read_content
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.store.sql.tables import artifacts
from service.scenes.models.scene import SceneSummary
from service.scenes.resource import scene_text
from service.scenes.store.record_cache import RecentScenes
from service.scenes.store.records import scenes
from service.scenes.store.scene_store import SceneStore
from service.scenes.tasks import Library, LoadedScene
from tests.service.jobs.databases import FullDisk
from tests.service.jobs.hosts import put

DOCUMENT = {"robots": [{"name": "arm", "model": "ur5e"}], "margin": 0.1 + 0.2}
UNCHECKED = Encoded(encode([{"bodies": ["a", "b"], "reason": "welded", "evidence": "w"}]))

LIBRARY = Library(model_roots=[], allow_paths=False)


def loaded(name, digest, document=None, summary=None):
    document = Encoded(encode(document or DOCUMENT))
    return LoadedScene(
        name=name,
        digest=digest,
        document=document,
        summary=SceneSummary.model_validate(summary or {}),
        unchecked=UNCHECKED,
    )


class Blocking:
    """A store whose coroutines are run to their end, all in one event loop."""

    def __init__(self, portal, store):
        self.portal, self.store = portal, store

    def __getattr__(self, name):
        found = getattr(self.store, name)
        return partial(self.portal.call, found) if iscoroutinefunction(found) else found


@pytest.fixture
def stores(engine, tmp_path):
    """Open a store of the documents in the test's folder."""
    with start_blocking_portal() as portal:

        def opened(of=engine):
            store = Blocking(portal, SceneStore(of, tmp_path, LIBRARY))
            store.open()
            return store

        yield opened


@pytest.fixture
def engine(tmp_path):
    made = create_engine(f"sqlite:///{tmp_path / 'scenes.sqlite'}")
    yield made
    made.dispose()


@pytest.fixture
def store(stores):
    return stores()


@pytest.fixture
def written(engine):
    """Read the artifact of a scene."""

    def read(record):
        with engine.connect() as connection:
            return json.loads(read_content(connection, record.artifact))

    return read


def test_what_is_added_is_found_by_another_store(store, stores):
    added = store.add(loaded("a", "d1", summary={"groups": []}))
    again = stores()
    assert again.get(added.id) == added
    assert again.get(added.id, 1).document == DOCUMENT


def test_unknown_scenes_and_revisions_are_refused(store):
    added = store.add(loaded("a", "d1"))
    for wrong in (("nothing",), (added.id, 2), ("nothing", 1)):
        with pytest.raises(UnknownResource):
            store.get(*wrong)
    with pytest.raises(UnknownResource):
        store.delete("nothing")


def test_pages_have_every_scene_once_newest_first(store):
    names = [store.add(loaded(f"s{i}", "d")).name for i in range(7)]
    seen, before, sizes = [], None, []
    while not sizes or before is not None:
        page, before = store.page(3, before)
        sizes.append(len(page))
        seen += [record.name for record in page]
    assert sizes == [3, 3, 1]
    assert seen == names[::-1]


def test_deleted_scenes_are_gone_but_their_artifact_stays(store, written):
    files = {"arm": {"named": "ur5e", "main": "a.urdf", "card": "", "sha256": {}}}
    added = store.add(loaded("a", "d1", summary={"files": files}))
    store.delete(added.id)
    with pytest.raises(UnknownResource):
        store.get(added.id)
    assert written(added) == {"document": DOCUMENT, "files": files}


def test_the_files_of_a_scene_are_stored_with_it(store, engine, tmp_path):
    """What a worker copied into the host's folder is in the database, once."""
    contents = [b"<robot/>", b"mesh", b"mesh"]
    digests = [put(tmp_path, content) for content in contents]
    kept = {"named": "ur5e", "main": "a.urdf", "card": ""}
    sha256 = dict(zip(("a.urdf", "b.obj", "c.obj"), digests, strict=True))
    for name in "ab":
        store.add(loaded(name, name, summary={"files": {"arm": {**kept, "sha256": sha256}}}))
    for path in (tmp_path / "files" / "bytes").iterdir():
        path.unlink()
    assert asyncio.run(ArtifactStore(engine).contents(digests)) == dict(
        zip(digests, contents, strict=True)
    )


def test_a_scene_whose_files_cannot_be_read_is_not_stored(store, engine):
    kept = {"named": "ur5e", "main": "a.urdf", "card": "", "sha256": {"a.urdf": "0" * 64}}
    with pytest.raises(OSError, match="No such file"):
        store.add(loaded("a", "d1", summary={"files": {"arm": kept}}))
    assert store.page(9, None) == ([], None)
    with engine.connect() as connection:
        assert connection.execute(select(artifacts.c.digest)).all() == []


def test_revisions_follow_one_another_and_stay_readable(store, written):
    first = store.add(loaded("a", "d1"))
    second = store.revise(first, loaded("a", "d2", {**DOCUMENT, "margin": 1.0}, {"groups": []}))
    assert (second.id, second.revision) == (first.id, 2)
    assert store.get(first.id) == second
    assert store.get(first.id, 1) == first
    assert written(first)["document"] == DOCUMENT
    assert written(second)["document"]["margin"] == 1.0
    store.delete(first.id)
    for revision in (None, 1, 2):
        with pytest.raises(UnknownResource):
            store.get(first.id, revision)
    with pytest.raises(UnknownResource):
        store.revise(second, loaded("a", "d3"))


def test_pairs_that_stay_the_same_are_written_once_and_read_with_every_revision(
    store, stores, engine
):
    """Also by a server that has to find them, and that has forgotten the revision before."""
    others = Encoded(encode([{"bodies": ["a", "c"], "reason": "welded", "evidence": "w"}]))
    pairs = [UNCHECKED, UNCHECKED, others, others, others, UNCHECKED]
    made = [store.add(loaded("a", "d1", summary={"groups": []}))]
    for i, unchecked in enumerate(pairs[1:]):
        told = loaded("a", f"d{i + 2}").model_copy(update={"unchecked": unchecked})
        if i == 4:
            store = stores()
        made.append(store.revise(made[-1], told))
    assert [record.unchecked_in for record in made] == [None, 1, None, 3, 3, None]
    with engine.connect() as connection:
        rows = connection.execute(select(scenes.c.summary).order_by(scenes.c.revision)).scalars()
        assert ["unchecked" in row for row in rows] == [True, False, True, False, False, True]
    again = stores()
    for record, unchecked in zip(made, pairs, strict=True):
        found = again.get(record.id, record.revision)
        assert found == record
        assert found.loaded.unchecked == unchecked
        assert json.loads(scene_text(found).text)["unchecked"] == json.loads(unchecked.text)
    again.delete(made[0].id)
    with pytest.raises(UnknownResource):
        again.get(made[3].id, 4)


def test_of_two_successors_one_is_refused(store):
    first = store.add(loaded("a", "d1"))
    with ThreadPoolExecutor(8) as pool:
        asked = [pool.submit(store.revise, first, loaded("a", f"d{i}")) for i in range(8)]
    refusals = [future.exception() for future in asked]
    assert refusals.count(None) == 1
    assert all(isinstance(r, RevisionConflict) for r in refusals if r is not None)
    assert store.get(first.id).revision == 2


def test_pages_have_the_latest_revision_at_the_place_of_the_first(store):
    made = [store.add(loaded(f"s{i}", "d")) for i in range(5)]
    page, before = store.page(2, None)
    revised = store.revise(made[1], loaded("s1 edited", "e"))
    seen = [record.name for record in page]
    while before is not None:
        page, before = store.page(2, before)
        seen += [record.name for record in page]
    assert seen == ["s4", "s3", "s2", "s1 edited", "s0"]
    assert revised.serial > made[4].serial


def test_what_finds_no_room_leaves_nothing_behind(tmp_path, stores):
    engine = open_engine(f"sqlite:///{tmp_path / 'scenes.sqlite'}")
    disk, store = FullDisk(engine), stores(engine)
    first = store.add(loaded("a", "d1"))
    disk.fill()
    large = {**DOCUMENT, "name": "x" * 100_000}
    with pytest.raises(DBAPIError, match="full"):
        store.add(loaded("b", "d2", large))
    with pytest.raises(DBAPIError, match="full"):
        store.revise(first, loaded("a", "d3", large))
    disk.free()
    assert [record.name for record in store.page(9, None)[0]] == ["a"]
    assert store.get(first.id) == first
    with engine.connect() as connection:
        assert len(connection.execute(select(artifacts.c.digest)).all()) == 1
    engine.dispose()


def test_records_are_read_again_only_when_they_were_put_aside(store, monkeypatch):
    made = [store.add(loaded(f"s{i}", "d")) for i in range(3)]
    monkeypatch.setattr("service.scenes.store.rows.read_record", None)
    assert [store.get(record.id).loaded for record in made] == [each.loaded for each in made]
    assert all(store.get(record.id) is store.get(record.id) for record in made)


def test_of_what_is_kept_the_oldest_goes_first_and_the_last_stays(store):
    a, b, c = (store.add(loaded(f"s{i}", "d")) for i in range(3))
    recent = RecentScenes(most_chars=2 * a.num_chars)
    for record in (a, b, a, c):
        recent.put(record)
        recent.get(a.id, 1)
    assert [recent.get(record.id, 1) for record in (a, b, c)] == [a, None, c]
    small = RecentScenes(most_chars=0)
    for record in (a, b, b):
        small.put(record)
    assert [small.get(record.id, 1) for record in (a, b)] == [None, b]


def test_a_scene_of_an_older_server_is_read_and_told(store, engine):
    """Its row was written member by member, and may lack what came later."""
    group = {"name": "arm", "aliases": [], "joints": [], "position_names": []}
    group |= {"velocity_names": [], "tool_frames": [], "configurations": {}, "positions": []}
    rates = ["lower", "upper", "blocks", "velocity", "acceleration", "jerk", "effort"]
    group["limits"] = {name: [] for name in rates}
    told = {"groups": [group], "frames": ["f"], "bodies": [], "num_pairs": 0, "assumed": []}
    told |= {"warnings": [], "unchecked": json.loads(UNCHECKED.text), "no_longer": "told"}
    row = {"id": "scn_old", "revision": 1, "digest": "d", "name": "old"}
    row |= {"created_at": "2026-01-02T03:04:05+00:00", "summary": told}
    former = encode_in_parts({"files": None, "document": Encoded(encode(DOCUMENT))})
    with engine.begin() as connection:
        row["artifact"] = ArtifactStore(engine).put(connection, Artifact(former.encode()), "d")
        connection.execute(insert(scenes).values(row))
    record = store.get("scn_old")
    assert record.document == DOCUMENT
    assert record.summary.frames == ["f"]
    assert record.summary.files is None
    answer = json.loads(scene_text(record).text)
    assert answer["document"] == DOCUMENT
    assert answer["unchecked"] == told["unchecked"]
    assert answer["files"] == {}
    assert "no_longer" not in answer
    assert answer["created_at"] == "2026-01-02T03:04:05Z"


def test_scenes_are_durable_although_they_share_connections_with_what_need_not_be(tmp_path, stores):
    """SQLite's `synchronous` is a connection's: 2 is FULL, which waits for the disk."""
    engine, levels = open_engine(f"sqlite:///{tmp_path / 'scenes.sqlite'}"), []
    store, jobs = stores(engine), JobStore(engine)
    jobs.open()

    def note(connection):
        levels.append(connection.exec_driver_sql("PRAGMA synchronous").scalar())

    event.listen(engine, "commit", note)
    identifier = jobs.insert(JobSpec("plan", "m:f", {}))[0].id
    jobs.start(identifier)
    added = store.add(loaded("a", "d"))
    jobs.append_events(identifier, [("stage", Encoded("{}"))])
    store.revise(added, loaded("a", "e"))
    jobs.append_events(identifier, [("stage", Encoded("{}"))])
    store.delete(added.id)
    engine.dispose()
    assert levels == [2, 1, 2, 1, 2, 1, 2]
