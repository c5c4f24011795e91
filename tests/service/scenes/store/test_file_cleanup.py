"""What no scene and no job needs is removed, and nothing else."""

import os
import shutil
import warnings
from collections import OrderedDict

import pytest
from sqlalchemy import create_engine, insert, select

from service.app import create_app
from service.jobs.store.sql.tables import artifacts, jobs
from service.scenes import world_cache
from service.scenes.store.file_cleanup import Sweeper, _is_owner, sweep
from service.settings import Settings
from tests.service.hostile.files import urdf

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient


@pytest.fixture
def settings(tmp_path):
    return Settings(engine="inline", data_dir=tmp_path / "data")


@pytest.fixture
def client(settings):
    with TestClient(create_app(settings)) as running:
        yield running


@pytest.fixture
def engine(settings, client):
    return create_engine(settings.url)


def post(client, tmp_path, lower):
    (tmp_path / "r.urdf").write_text(urdf(limit=f'<limit lower="{lower}" upper="1" velocity="1"/>'))
    document = {"name": "s", "robots": [{"name": "r", "model": str(tmp_path / "r.urdf")}]}
    return client.post("/v1/scenes", json=document).json()


def kept(settings):
    """Artifacts, copies and folders that there are."""
    engine = create_engine(settings.url)
    with engine.connect() as connection:
        stored = set(connection.execute(select(artifacts.c.digest)).scalars())
    engine.dispose()
    folders = ("files/bytes", "files/folders")
    return [stored, *({e.name for e in (settings.data_dir / f).iterdir()} for f in folders)]


def files_of(scene):
    return set(scene["files"]["r"]["sha256"].values())


def answers(client, scene):
    body = {"group": "r", "configurations": [[0.0]]}
    return client.post(f"/v1/scenes/{scene['id']}/check", json=body).is_success


def test_what_a_scene_needs_stays_and_the_rest_goes(client, settings, engine, tmp_path):
    first, second = post(client, tmp_path, -1), post(client, tmp_path, -2)
    both = kept(settings)
    sweep(engine, settings.data_dir, grace=-1)
    assert kept(settings) == both
    client.delete(f"/v1/scenes/{second['id']}")
    sweep(engine, settings.data_dir)  # it was there a moment ago
    assert kept(settings) == both
    sweep(engine, settings.data_dir, grace=-1)
    stored, copies, folders = kept(settings)
    assert len(stored) == 1 + len(files_of(first))  # one is the document
    assert files_of(first) <= copies <= stored
    assert len(folders) == 1
    assert answers(client, first)


def test_what_never_became_a_scene_goes(client, settings, engine, tmp_path):
    first = post(client, tmp_path, -1)
    assert post(client, tmp_path, 5)["code"] == "model_invalid"
    sweep(engine, settings.data_dir, grace=-1)
    assert kept(settings)[1] == files_of(first)


def test_what_a_job_was_made_in_stays_after_its_scene(client, settings, engine, tmp_path):
    scene = post(client, tmp_path, -1)
    before = kept(settings)
    row = {column.name: "" for column in jobs.c if not column.nullable}
    row |= {"world_digest": scene["digest"], "id": "pln_1"}
    row |= {c.name: 0 for c in jobs.c if not c.nullable and c.type.python_type is int}
    row |= {c.name: 0.0 for c in jobs.c if not c.nullable and c.type.python_type is float}
    row |= {c.name: False for c in jobs.c if not c.nullable and c.type.python_type is bool}
    row.pop("sequence", None)
    with engine.begin() as connection:
        connection.execute(insert(jobs).values(row))
    client.delete(f"/v1/scenes/{scene['id']}")
    sweep(engine, settings.data_dir, grace=-1)
    assert kept(settings) == before


def test_copies_that_are_lost_come_again(client, settings, engine, tmp_path, monkeypatch):
    scene = post(client, tmp_path, -1)
    shutil.rmtree(settings.data_dir / "files")
    sweep(engine, settings.data_dir, grace=-1)
    monkeypatch.setattr(world_cache, "_idle", OrderedDict())
    assert answers(client, scene)
    assert files_of(scene) < kept(settings)[1] == kept(settings)[0]


def test_the_files_of_another_database_are_left_alone(settings, engine, client, tmp_path):
    post(client, tmp_path, -1)
    before = kept(settings)
    other = create_engine("sqlite://")
    assert not _is_owner(settings.data_dir / "files", "another")
    Sweeper(other, settings.data_dir, "another")._sweep()
    assert kept(settings) == before


def test_files_that_are_used_again_are_young_again(client, settings, engine, tmp_path):
    scene = post(client, tmp_path, -1)
    entries = [e for f in ("bytes", "folders") for e in (settings.data_dir / "files" / f).iterdir()]
    for entry in entries:
        os.utime(entry, (0, 0))
    client.delete(f"/v1/scenes/{scene['id']}")
    again = post(client, tmp_path, -1)
    client.delete(f"/v1/scenes/{again['id']}")
    sweep(engine, settings.data_dir)
    assert all(entry.exists() for entry in entries)


def test_what_a_killed_server_left_half_written_goes(client, settings, engine, tmp_path):
    scene = post(client, tmp_path, -1)
    rest = settings.data_dir / "files" / "bytes" / ".part-of-some-scene"
    rest.mkdir()
    (rest / "half").write_text("{")
    sweep(engine, settings.data_dir)  # it was there a moment ago
    assert rest.exists()
    sweep(engine, settings.data_dir, grace=-1)
    assert not rest.exists()
    assert answers(client, scene)
