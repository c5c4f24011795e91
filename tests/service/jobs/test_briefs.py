"""Lists read briefs and no bodies, and what older versions wrote is listed as well."""

from contextlib import contextmanager
from dataclasses import fields, replace
from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import event, insert, select, text

from planning.errors import Canceled, NoPathFound
from service.executions.tasks import EXECUTE
from service.jobs.job import JobSpec, JobSummary
from service.jobs.json_text import Encoded, encode
from service.jobs.outline import without
from service.jobs.states import JobState
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.store.sql.schema import stored_revision
from service.jobs.store.sql.tables import bodies, jobs, summaries
from service.jobs.task import outline_of
from service.plans.tasks import PLAN as PLAN_TASK
from service.plans.tasks import REVERSE as REVERSE_TASK
from service.regions.tasks import GROW_REGIONS
from tests.service.jobs.databases import FORMER_NAMES, make_released

PLAN, REVERSE, REGIONS = PLAN_TASK.name, REVERSE_TASK.name, GROW_REGIONS.name
LARGE = [[0.1] * 7] * 50
PAYLOAD = {"request": {"seed": 1}, "revision": 2, "motion": LARGE, "trajectory": LARGE}
RESULTS = {
    PLAN: {"result": LARGE, "polynomial": LARGE, "graph": None, "timings": {"goals": 0.1 + 0.2}},
    REVERSE: {"result": LARGE, "polynomial": LARGE, "timings": {}, "digest": "d"},
    REGIONS: {"result": {"regions": LARGE, "portals": [], "num_regions": 1}, "timings": {"x": 1}},
    EXECUTE.name: {"status": {"positions": [0.5], "time": 1.5}},
    "m:f": {"anything": LARGE},
}
NO_PATH = NoPathFound("none", {"graph": LARGE, "approximate": {"goal_distance": 0.5}})


@pytest.fixture
def engine(tmp_path):
    made = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    yield made
    made.dispose()


@contextmanager
def statements(engine):
    """What is asked of the database meanwhile."""
    told = []

    def listen(_, __, statement, *___):
        told.append(statement)

    event.listen(engine, "before_cursor_execute", listen)
    try:
        yield told
    finally:
        event.remove(engine, "before_cursor_execute", listen)


def add_some(store):
    """Jobs of every task in every state; what tasks gave is told without a brief of their own."""
    for task, result in RESULTS.items():
        for how in JobState:
            job, _ = store.insert(JobSpec("plan", task, PAYLOAD, scene="s"))
            if how in {JobState.QUEUED, JobState.CANCELED}:
                if how is JobState.CANCELED:
                    store.cancel_queued(job.id, Canceled("on request"))
                continue
            store.start(job.id)
            if how is JobState.SUCCEEDED:
                short = without(result, outline_of(task).result)
                store.succeed(job.id, Encoded(encode(result)), Encoded(encode(short)))
            if how is JobState.FAILED:
                store.fail(job.id, NO_PATH)


def assert_listed(store, engine):
    """Every job is listed as it is but for what is large, and nothing large is read for it."""
    with statements(engine) as told:
        page = store.page("plan", {"scene": "s"}, limit=100)
    assert told
    assert not any("job_bodies" in statement for statement in told)
    assert len(page) == len(RESULTS) * len(JobState)
    for brief in page:
        whole, outline = store.get(brief.id), outline_of(brief.task)
        expected = replace(
            whole,
            **{part: without(getattr(whole, part), getattr(outline, part)) for part in PARTS},
        )
        names = [field.name for field in fields(JobSummary)]
        assert [getattr(brief, n) for n in names] == [getattr(expected, n) for n in names]
        if brief.task in {PLAN, REVERSE}:
            assert "motion" not in brief.payload
            assert len(encode([brief.result, brief.failure])) < 400
        if brief.task in {REGIONS, EXECUTE.name}:
            assert len(encode(brief.result)) < 400


PARTS = ("payload", "result", "failure")


def leave_to_upgrade(engine, store):
    """Make a database what version 0.1 may leave: no summaries, or without ends."""
    store.open()
    add_some(store)
    make_released(engine)
    odd = "DELETE FROM job_briefs WHERE job IN (SELECT id FROM jobs WHERE serial % 2 = 1)"
    with engine.begin() as connection:
        connection.execute(text(odd))
        connection.execute(text("UPDATE job_briefs SET result = NULL, failure = NULL"))


def check_upgrade(engine):
    """A database of version 0.1 is listed as one of this version, and looked at once."""
    store = JobStore(engine)
    leave_to_upgrade(engine, store)
    store.open()
    assert_listed(store, engine)
    assert {job.task for job in store.page("plan", limit=100)} == set(RESULTS)
    with statements(engine) as told:
        store.open()
    assert not any("jobs" in statement for statement in told)


def test_lists_have_all_but_what_is_large(engine):
    store = JobStore(engine)
    store.open()
    add_some(store)
    assert_listed(store, engine)


def test_what_an_older_version_wrote_is_listed_as_well(engine):
    check_upgrade(engine)


def test_an_upgrade_that_is_interrupted_loses_nothing(engine):
    store = JobStore(engine)
    leave_to_upgrade(engine, store)
    portions = count(1)

    def interrupt(_, __, statement, *___):
        if statement.startswith("INSERT INTO job_briefs") and next(portions) == 2:
            raise KeyboardInterrupt

    event.listen(engine, "before_cursor_execute", interrupt)
    with pytest.raises(KeyboardInterrupt):
        store.open()
    event.remove(engine, "before_cursor_execute", interrupt)
    assert stored_revision(engine) == "0001"
    with engine.connect() as connection:
        names = set(connection.execute(text("SELECT task FROM jobs")).scalars())
        kept = connection.execute(text("SELECT job FROM job_briefs")).all()
    assert names == {*FORMER_NAMES, "m:f"}
    assert len(kept) == len(RESULTS) * len(JobState) // 2
    store.open()
    assert_listed(store, engine)


def test_jobs_without_a_body_do_not_keep_a_store_from_opening(engine):
    """As nothing writes them: rows that somebody lost."""
    store = JobStore(engine)
    store.open()
    add_some(store)
    with engine.begin() as connection:
        lost = connection.execute(select(jobs.c.id).limit(3)).scalars().all()
        connection.execute(bodies.delete().where(bodies.c.job.in_(lost)))
        connection.execute(summaries.delete().where(summaries.c.job.in_(lost)))
        connection.execute(insert(bodies).values(job="nobody", payload={}))
    make_released(engine)
    store.open()
    assert len(store.page("plan", limit=100)) == len(RESULTS) * len(JobState) - 3


JSON = st.recursive(
    st.integers() | st.text(max_size=2),
    lambda inner: st.dictionaries(st.sampled_from("abc"), inner) | st.lists(inner, max_size=2),
    max_leaves=12,
)
MEMBERS = st.lists(st.lists(st.sampled_from("abc"), min_size=1, max_size=3).map(".".join))


def at(content, path):
    for name in path:
        if not isinstance(content, dict) or name not in content:
            return None
        content = content[name]
    return [content]


@given(JSON, MEMBERS)
def test_what_is_left_out_is_gone_and_the_rest_is_in_its_place(content, members):
    before = encode(content)
    short = without(content, tuple(members))
    assert encode(content) == before
    left_out = [member.split(".") for member in members]
    for path in ([a, *b] for a in "abc" for b in ([], ["a"], ["b"], ["c"])):
        if any(path[: len(out)] == out for out in left_out):
            assert at(short, path) is None
        elif not any(out[: len(path)] == path for out in left_out):
            assert at(short, path) == at(content, path)
