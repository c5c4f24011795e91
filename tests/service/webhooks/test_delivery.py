"""What happens to jobs is told at least once, signed, in order, whatever ends in between."""

import asyncio
import json
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta

import pytest
from anyio import to_thread
from sqlalchemy import func, select
from standardwebhooks import Webhook, WebhookVerificationError

from planning.errors import Canceled, NoPathFound
from service.jobs.job import JobSpec
from service.jobs.json_text import Encoded
from service.jobs.store.deletion import delete_job
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.webhooks.delivery import RETRY_DELAYS, DeliveryTerms, WebhookDelivery
from service.webhooks.records import notices
from service.webhooks.store import WebhookStore
from tests.profiles import only_campaign
from tests.service.jobs.postgres import cluster
from tests.service.servers import until
from tests.service.webhooks.receiver import receiver

ON_BOTH = pytest.mark.parametrize("engine", ["sqlite", "postgresql"], indirect=True)
FINISHED = ["plan.finished"]
EAGER = DeliveryTerms(may_be_private=True, delays=(0.0,) * 20)


@pytest.fixture
def engine(request, tmp_path):
    if getattr(request, "param", "sqlite") == "postgresql":
        with cluster() as server:
            made = open_engine(server.url)
            yield made
            made.dispose()
        return
    made = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    yield made
    made.dispose()


@pytest.fixture
def jobs(engine):
    made = JobStore(engine)
    made.open()
    return made


@pytest.fixture
def webhooks(engine, jobs):
    return WebhookStore(engine)


@pytest.fixture
def target():
    with receiver() as running:
        yield running


def left(engine):
    with engine.connect() as connection:
        return connection.execute(select(func.count()).select_from(notices)).scalar_one()


@asynccontextmanager
async def delivering(jobs, webhooks, terms=EAGER, **clock):
    delivery = WebhookDelivery(webhooks, terms, **clock)
    jobs.on_event = delivery.note
    task = asyncio.get_running_loop().create_task(delivery.run())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def begin(jobs, prefix="pln", **more):
    job, _ = jobs.insert(JobSpec("plan", "t", {}, prefix=prefix, **more))
    jobs.start(job.id)
    return job.id


def finish(jobs, prefix="pln", **more):
    job = begin(jobs, prefix, **more)
    jobs.succeed(job, Encoded("{}"))
    return job


async def until_so(ask, *given):
    """Wait in a thread until an answer is true."""
    await to_thread.run_sync(until, lambda: ask(*given))


async def settled(engine):
    """Wait until nothing is left to tell."""
    await until_so(lambda: not left(engine))


@ON_BOTH
def test_an_end_is_told_once_and_its_signature_holds(engine, jobs, webhooks, target):
    hook = webhooks.add(f"{target.url}/hook?a=1", FINISHED)

    async def story():
        async with delivering(jobs, webhooks):
            job = await to_thread.run_sync(lambda: finish(jobs, scene="scn_1", batch="bat_1"))
            await to_thread.run_sync(target.wait_for, 1)
            await settled(engine)
            return job

    job = asyncio.run(story())
    [(headers, body)] = target.posts
    assert headers[":path"] == "/hook?a=1"
    assert headers["host"] == target.url.removeprefix("http://")
    assert headers["webhook-id"] == f"msg_{job}_3"
    told = Webhook(hook.secret).verify(body, headers)
    assert told["type"] == "plan.finished"
    assert told["data"] == {
        "kind": "plan",
        "id": job,
        "event": 3,
        "scene": "scn_1",
        "batch": "bat_1",
        "state": "succeeded",
        "failure": None,
    }
    assert told["timestamp"].endswith("Z")
    with pytest.raises(WebhookVerificationError):
        Webhook(hook.secret).verify(body + b" ", headers)
    with pytest.raises(WebhookVerificationError):
        Webhook(webhooks.add(target.url, FINISHED).secret).verify(body, headers)


def test_only_what_is_wanted_is_told_and_failures_without_their_evidence(
    engine, jobs, webhooks, target
):
    webhooks.add(target.url, ["execution.started", "plan.finished"])

    async def story():
        async with delivering(jobs, webhooks):
            await to_thread.run_sync(finish, jobs, "reg")
            started = await to_thread.run_sync(begin, jobs, "exe")
            failed = await to_thread.run_sync(begin, jobs)
            error = NoPathFound("none", {"graph": [0.0] * 1000})
            await to_thread.run_sync(jobs.fail, failed, error)
            await to_thread.run_sync(target.wait_for, 2)
            await settled(engine)
            return started, failed

    started, failed = asyncio.run(story())
    told = {json.loads(body)["data"]["id"]: json.loads(body) for _, body in target.posts}
    assert set(told) == {started, failed}
    assert told[started]["type"] == "execution.started"
    assert "state" not in told[started]["data"]
    failure = told[failed]["data"]["failure"]
    assert failure == {"code": "no_path_found", "stage": "search", "detail": "none"}


@only_campaign("10 s for each database")
@ON_BOTH
def test_what_is_refused_is_sent_again_and_events_of_a_job_stay_in_order(
    engine, jobs, webhooks, target
):
    hook = webhooks.add(target.url, ["plan.started", "plan.requeued", "plan.finished"])
    target.answers = [500, 302, 404, 503, 200, 500]

    async def story():
        async with delivering(jobs, webhooks):
            job = await to_thread.run_sync(begin, jobs)
            await to_thread.run_sync(jobs.requeue, job, "the server stopped")
            await to_thread.run_sync(jobs.start, job)
            await to_thread.run_sync(jobs.cancel, job, Canceled("on request"))
            await settled(engine)

    asyncio.run(story())
    ids = [headers["webhook-id"] for headers, _ in target.posts]
    numbers = [int(identifier.rsplit("_", 1)[1]) for identifier in ids]
    assert numbers == [2] * 5 + [3] * 2 + [4, 5]
    assert all(headers[":path"] == "/" for headers, _ in target.posts)  # no redirection
    for headers, body in target.posts:
        Webhook(hook.secret).verify(body, headers)
    found = webhooks.get(hook.id)
    assert (found.failing_since, found.reason) == (None, "")


def test_a_job_whose_message_fails_holds_up_no_other_job(engine, jobs, webhooks, target):
    webhooks.add(target.url, FINISHED)
    target.answers = [500]
    patient = DeliveryTerms(may_be_private=True, delays=(3600.0,))

    async def story():
        async with delivering(jobs, webhooks, patient):
            first = await to_thread.run_sync(finish, jobs)
            await to_thread.run_sync(target.wait_for, 1)
            second = await to_thread.run_sync(finish, jobs)
            await to_thread.run_sync(target.wait_for, 2)
            # It is noted as told once the target's answer has come.
            await until_so(lambda: left(engine) == 1)
            return first, second

    told = asyncio.run(story())
    assert [json.loads(body)["data"]["id"] for _, body in target.posts] == list(told)
    assert left(engine) == 1


def test_what_a_server_left_the_next_one_tells(engine, jobs, webhooks, target):
    hook = webhooks.add(target.url, FINISHED)
    target.answers = [500] * 3
    patient = DeliveryTerms(may_be_private=True, delays=(3600.0,))
    now = datetime.now(UTC)

    async def first():
        async with delivering(jobs, webhooks, patient):
            for _ in range(3):
                await to_thread.run_sync(finish, jobs)
            await to_thread.run_sync(target.wait_for, 3)
            await until_so(lambda: webhooks.get(hook.id).reason)

    asyncio.run(first())
    assert left(engine) == 3
    # Ended while no delivery ran, as in recovery: nothing was looked at yet.
    again, unseen = WebhookStore(engine), JobStore(engine)
    unseen.on_event = again.note
    finish(unseen)
    assert left(engine) == 4

    async def second():
        later = now + timedelta(hours=2)
        async with delivering(jobs, again, clock=lambda: later):
            await settled(engine)

    asyncio.run(second())
    ids = [headers["webhook-id"] for headers, _ in target.posts]
    before, after = ids[:3], ids[3:]  # in any order: they are of different jobs
    assert set(before) < set(after)
    assert len(set(after)) == len(after) == 4


def test_who_says_gone_is_told_nothing_more(engine, jobs, webhooks, target):
    hook = webhooks.add(target.url, FINISHED)
    target.answers = [410]

    async def story():
        async with delivering(jobs, webhooks):
            await to_thread.run_sync(finish, jobs)
            await to_thread.run_sync(target.wait_for, 1)
            await settled(engine)
            await to_thread.run_sync(finish, jobs)
            assert await to_thread.run_sync(left, engine) == 0
            await to_thread.run_sync(webhooks.enable, hook.id)
            await to_thread.run_sync(finish, jobs)
            await to_thread.run_sync(target.wait_for, 2)

    asyncio.run(story())
    assert len(target.posts) == 2
    assert webhooks.get(hook.id).disabled_at is None


def test_a_webhook_that_takes_nothing_for_days_is_disabled(engine, jobs, webhooks, target):
    hook = webhooks.add(target.url, FINISHED)
    target.answers = [500] * 100
    now = [datetime.now(UTC) + timedelta(minutes=1)]

    def clock():
        return now[0]

    async def story():
        async with delivering(jobs, webhooks, DeliveryTerms(may_be_private=True), clock=clock):
            await to_thread.run_sync(finish, jobs)
            await to_thread.run_sync(target.wait_for, 1)
            await until_so(lambda: webhooks.get(hook.id).failing_since)
            assert (await to_thread.run_sync(webhooks.get, hook.id)).disabled_at is None
            now[0] += timedelta(days=5, seconds=1)
            await until_so(lambda: webhooks.get(hook.id).disabled_at)

    asyncio.run(story())
    assert left(engine) == 0
    assert webhooks.get(hook.id).reason == "answered 500"
    assert not webhooks.is_needed


@only_campaign("4 s")
def test_a_message_is_given_up_after_its_last_delay(engine, jobs, webhooks, target):
    webhooks.add(target.url, FINISHED)
    target.answers = [500] * 100
    terms = DeliveryTerms(may_be_private=True, delays=(0.0, 0.0))

    async def story():
        async with delivering(jobs, webhooks, terms):
            await to_thread.run_sync(finish, jobs)
            await settled(engine)

    asyncio.run(story())
    assert len(target.posts) == 3
    assert sum(RETRY_DELAYS) > 2 * 86_400


@ON_BOTH
def test_two_that_send_at_once_send_each_message_once(engine, jobs, webhooks, target):
    webhooks.add(target.url, FINISHED)
    jobs.on_event = webhooks.note
    for _ in range(20):
        finish(jobs)

    async def story():
        other = WebhookStore(engine)
        async with delivering(jobs, webhooks), delivering(jobs, other):
            await settled(engine)

    asyncio.run(story())
    ids = [headers["webhook-id"] for headers, _ in target.posts]
    assert len(set(ids)) == 20 == len(ids)


def test_nothing_is_sent_to_a_private_address_unless_it_may(engine, jobs, webhooks, target):
    hook = webhooks.add(target.url, FINISHED)
    named = webhooks.add(target.url.replace("127.0.0.1", "localhost"), FINISHED)

    async def story():
        async with delivering(jobs, webhooks, DeliveryTerms()):
            await to_thread.run_sync(finish, jobs)
            for name in (hook.id, named.id):
                await until_so(lambda name: "not public" in webhooks.get(name).reason, name)

    asyncio.run(story())
    assert target.posts == []
    assert left(engine) == 2


def test_a_name_that_leads_nowhere_is_a_failure_like_any_other(engine, jobs, webhooks, target):
    hook = webhooks.add("http://nowhere.invalid/", FINISHED)

    async def story():
        terms = DeliveryTerms(delays=(3600.0,))
        async with delivering(jobs, webhooks, terms):
            await to_thread.run_sync(finish, jobs)
            await until_so(lambda: webhooks.get(hook.id).reason)

    asyncio.run(story())
    assert left(engine) == 1


def test_however_many_fail_they_write_one_after_another(engine, jobs, webhooks, monkeypatch):
    writing, most = [], []

    def counted(write):
        def count(*given, **more):
            writing.append(write)
            most.append(len(writing))
            try:
                return write(*given, **more)
            finally:
                writing.remove(write)

        return count

    for name in ("claim", "note_failure", "postpone"):
        monkeypatch.setattr(webhooks, name, counted(getattr(webhooks, name)))
    hooks = [webhooks.add("http://nowhere.invalid/", FINISHED).id for _ in range(30)]

    async def story():
        async with delivering(jobs, webhooks, DeliveryTerms(delays=(3600.0,))):
            for _ in range(3):
                await to_thread.run_sync(finish, jobs)
            await until_so(lambda: all(webhooks.get(hook).reason for hook in hooks))

    asyncio.run(story())
    assert max(most) == 1


def test_what_is_deleted_meanwhile_is_not_told(engine, jobs, webhooks, target):
    webhooks.add(target.url, FINISHED)
    jobs.on_event = webhooks.note
    gone, kept = finish(jobs), finish(jobs)
    delete_job(jobs, gone)

    async def story():
        async with delivering(jobs, webhooks):
            await settled(engine)

    asyncio.run(story())
    assert [json.loads(body)["data"]["id"] for _, body in target.posts] == [kept]


def test_nothing_is_noted_where_nothing_is_wanted(engine, jobs, webhooks):
    webhooks.refresh()
    jobs.on_event = webhooks.note
    finish(jobs)
    assert left(engine) == 0
    hook = webhooks.add("http://example.org/", FINISHED)
    finish(jobs, prefix="job")
    assert left(engine) == 0
    finish(jobs)
    assert left(engine) == 1
    webhooks.delete(hook.id)
    assert left(engine) == 0
