"""Scenes survive the server; their files can be lost."""

import json

import pytest
from sqlalchemy import create_engine

from service.errors import UnknownResource
from service.scenes.store import SceneStore

DOCUMENT = {"robots": [{"name": "arm", "model": "ur5e"}], "margin": 0.1 + 0.2}


@pytest.fixture
def engine(tmp_path):
    made = create_engine(f"sqlite:///{tmp_path / 'scenes.sqlite'}")
    yield made
    made.dispose()


@pytest.fixture
def store(engine, tmp_path):
    opened = SceneStore(engine, tmp_path / "documents")
    opened.open()
    return opened


def test_what_is_added_is_found_by_another_store(store, engine, tmp_path):
    added = store.add("a", "d1", DOCUMENT, {"groups": []})
    again = SceneStore(engine, tmp_path / "documents")
    again.open()
    assert again.get(added.id) == added
    assert again.get(added.id, 1).document == DOCUMENT


def test_unknown_scenes_and_revisions_are_refused(store):
    added = store.add("a", "d1", DOCUMENT, {})
    for wrong in (("nothing",), (added.id, 2), ("nothing", 1)):
        with pytest.raises(UnknownResource):
            store.get(*wrong)
    with pytest.raises(UnknownResource):
        store.delete("nothing")


def test_pages_have_every_scene_once_newest_first(store):
    names = [store.add(f"s{i}", "d", DOCUMENT, {}).name for i in range(7)]
    seen, before = [], None
    while page := store.page(3, before):
        seen += [record.name for record in page]
        before = page[-1].serial
    assert seen == names[::-1]


def test_deleted_scenes_are_gone_but_their_file_stays(store):
    added = store.add("a", "d1", DOCUMENT, {})
    file = store.file(added)
    store.delete(added.id)
    with pytest.raises(UnknownResource):
        store.get(added.id)
    assert json.loads(file.read_text()) == DOCUMENT


def test_a_lost_file_is_written_again_bit_for_bit(store):
    added = store.add("a", "d1", DOCUMENT, {})
    before = store.file(added).read_bytes()
    store.file(added).unlink()
    assert store.file(added).read_bytes() == before
