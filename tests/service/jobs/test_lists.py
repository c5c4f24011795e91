"""A page of a list reads its own rows, however many others there are."""

import asyncio
import itertools

import pytest
from sqlalchemy import event, inspect, text

from service.jobs.job import JobSpec
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.scenes.store.scene_store import SceneStore
from service.scenes.tasks import Library
from tests.service.jobs.databases import make_released

# Every way in which lists are asked for.
FILTERS = [
    dict(zip(("state", "scene", "world_digest"), chosen, strict=True))
    for chosen in itertools.product([None, "queued"], [None, "s1"], [None])
] + [{"world_digest": "w1"}]

LIBRARY = Library(model_roots=[], allow_paths=False)


@pytest.fixture
def engine(tmp_path):
    made = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    yield made
    made.dispose()


def asked_by(engine, work):
    """The statements of some work, with their parameters."""
    told = []

    def listen(_, __, statement, parameters, *___):
        told.append((statement, parameters))

    event.listen(engine, "before_cursor_execute", listen)
    work()
    event.remove(engine, "before_cursor_execute", listen)
    return told


def steps(engine, asked):
    """How the database goes about some statements."""
    found = []
    with engine.connect() as connection:
        for statement, parameters in asked:
            explained = connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters)
            found += [row.detail for row in explained]
    return found


def assert_reads_only_its_rows(found):
    assert found
    for step in found:
        assert not step.startswith("SCAN jobs"), found
        assert not step.startswith("SCAN job_"), found
        assert not step.startswith("SCAN scenes"), found
        assert "TEMP B-TREE" not in step, found


@pytest.mark.parametrize("wanted", FILTERS, ids=str)
@pytest.mark.parametrize("before", [None, 40])
def test_a_page_of_jobs_reads_its_own_rows(engine, wanted, before):
    store = JobStore(engine)
    store.open()
    for i in range(60):
        store.insert(JobSpec("plan" if i % 3 else "regions", "m:f", {}, scene=f"s{i % 2}"))
    asked = asked_by(engine, lambda: store.page("plan", wanted, before=before, limit=5))
    assert_reads_only_its_rows(steps(engine, asked))


def test_a_page_of_scenes_reads_its_own_rows(engine, tmp_path):
    store = SceneStore(engine, tmp_path / "scenes", LIBRARY)
    asyncio.run(store.open())
    for before in (None, 40):
        asked = asked_by(engine, lambda before=before: asyncio.run(store.page(5, before)))
        found = steps(engine, asked)
        # The page itself is what is gone through in the end.
        assert_reads_only_its_rows([step for step in found if "TEMP B-TREE FOR ORDER" not in step])


def test_databases_of_older_versions_get_the_indices(engine):
    store = JobStore(engine)
    store.open()
    make_released(engine)
    with engine.begin() as connection:
        for index in inspect(connection).get_indexes("jobs"):
            connection.execute(text(f"DROP INDEX {index['name']}"))
        connection.execute(text("DROP TABLE alembic_version"))
        connection.execute(text("CREATE INDEX jobs_by_scene ON jobs (scene, serial)"))
    store.open()
    asked = asked_by(engine, lambda: store.page("plan", {"scene": "s"}, before=9, limit=5))
    assert_reads_only_its_rows(steps(engine, asked))
