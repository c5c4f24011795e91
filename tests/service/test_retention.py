"""Jobs are deleted when they are old, whole, and not while anything needs them."""

from datetime import UTC, datetime, timedelta

import pytest
from sqlalchemy import create_engine, func, insert, select, update

from service.jobs.job import JobSpec
from service.jobs.json_text import Encoded
from service.jobs.store.deletion import _EVENTS_AT_ONCE
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.schema import bring_up_to_date
from service.jobs.store.sql.tables import bodies, events, jobs, makers, summaries
from service.retention import Retention
from service.scenes.store.records import scenes

NOW = datetime(2020, 1, 1, tzinfo=UTC)
DAY = timedelta(days=1)


@pytest.fixture
def engine(tmp_path):
    made = create_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    bring_up_to_date(made)
    yield made
    made.dispose()


@pytest.fixture
def store(engine):
    made = JobStore(engine, {"tests": "1"})
    made.open()
    return made


@pytest.fixture
def add(store, engine):
    """Adds a job that ended so many days ago, or has not ended."""

    def make(lane="plan", days=None, **given):
        prefix = {"plan": "pln", "execution": "exe", "regions": "reg"}[lane]
        payload = given.pop("payload", {})
        job, _ = store.insert(JobSpec(lane, "t", payload, prefix=prefix, **given))
        store.start(job.id)
        store.append_events(job.id, [("status", Encoded("{}"))] * 3)
        if days is not None:
            store.succeed(job.id, Encoded("{}"))
            at = (NOW - days * DAY).isoformat()
            with engine.begin() as connection:
                row = update(jobs).where(jobs.c.id == job.id)
                connection.execute(row.values(finished_at=at))
        return job.id

    return make


@pytest.fixture
def add_scene(engine):
    def make(identifier, digest="d"):
        row = {"id": identifier, "revision": 1, "digest": digest, "name": "", "created_at": ""}
        with engine.begin() as connection:
            connection.execute(insert(scenes).values(row | {"artifact": "a", "summary": {}}))

    return make


def left(engine):
    with engine.connect() as connection:
        return set(connection.execute(select(jobs.c.id)).scalars())


def sweep(store, days=30):
    return Retention(store, days).sweep(NOW - days * DAY)


def test_what_is_old_goes_with_all_that_was_recorded(store, engine, add):
    old, young, running = add(days=31), add(days=29), add()
    with engine.connect() as connection:
        before = connection.execute(select(func.count()).select_from(events)).scalar_one()
    assert sweep(store) == 1
    assert left(engine) == {young, running}
    with engine.connect() as connection:
        for table in (bodies, summaries, makers, events):
            named = set(connection.execute(select(table.c.job).distinct()).scalars())
            assert old not in named
            assert {young, running} <= named
        after = connection.execute(select(func.count()).select_from(events)).scalar_one()
    assert before - after == 6  # queued, started, three statuses, finished
    assert sweep(store) == 0


def test_more_jobs_and_events_go_than_fit_into_a_transaction(store, engine, add):
    long = add()
    store.append_events(long, [("status", Encoded("{}"))] * (_EVENTS_AT_ONCE + 1))
    store.succeed(long, Encoded("{}"))
    with engine.begin() as connection:
        connection.execute(update(jobs).values(finished_at=(NOW - 40 * DAY).isoformat()))
    for _ in range(60):
        add(days=31)
    assert sweep(store) == 61
    with engine.connect() as connection:
        assert connection.execute(select(events)).first() is None


def test_regions_stay_as_long_as_the_scene_they_have_grown_in(store, engine, add, add_scene):
    add_scene("here", "digest")
    kept = add("regions", days=40, scene="here", world_digest="digest")
    add("regions", days=40, scene="here", world_digest="edited since")
    assert sweep(store) == 1
    assert left(engine) == {kept}


def test_what_a_job_names_stays_until_it_has_ended(store, engine, add):
    plan = add("plan", days=40)
    named = {"request": {"plan": plan}}
    running = add("execution", payload=named)
    assert sweep(store) == 0
    store.succeed(running, Encoded("{}"))
    assert sweep(store) == 1
    assert left(engine) == {running}
