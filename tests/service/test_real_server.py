"""The service as users run it, with several processes for one plan's attempts."""

import os
import signal

import pytest

from service.client.errors import ApiError
from tests.service.servers import ARM, endless, helpers_of, living, request_of, until


@pytest.fixture
def client(real_server):
    return real_server.client


@pytest.fixture
def running(client):
    """A plan that is being searched for, and is canceled after the test."""
    job = client.submit_plan(endless(client))
    until(lambda: client.plan(job.id).stage == "search")
    yield job
    client.cancel_plan(job.id)
    until(lambda: client.plan(job.id).finished_at)


@pytest.fixture
def helpers(real_server, running):
    """The processes that make the plan's attempts."""
    return until(lambda: helpers_of(real_server.process.pid))


def test_a_plan_streams_its_events(client):
    job = client.submit_plan(request_of(client.add_scene(ARM), seed=4))
    types = [event.type for event in client.plan_events(job.id)]
    assert types[:2] == ["queued", "started"]
    assert types[-1] == "finished"
    assert client.plan(job.id).state == "succeeded"


def test_the_server_answers_while_it_plans(client, running):
    with pytest.raises(ApiError) as refusal:
        client.add_scene(b"robots: []")
    assert refusal.value.problem.code == "scene_invalid"
    with pytest.raises(ApiError) as refusal:
        client.plan("pln_nothing")
    assert refusal.value.problem.status == 404
    assert client.plan(running.id).state == "running"


def test_a_canceled_plan_ends_long_before_its_time_and_its_helpers_with_it(
    real_server, client, running, helpers
):
    client.cancel_plan(running.id)
    ended = until(lambda: (job := client.plan(running.id)).finished_at and job)
    assert ended.state == "canceled"
    until(lambda: not set(helpers) & set(living()))
    assert not helpers_of(real_server.process.pid)


def test_a_worker_that_is_killed_takes_no_other_plan_with_it(client, running, helpers):
    (worker,) = set(helpers.values())
    os.kill(worker, signal.SIGKILL)
    until(lambda: not {worker, *helpers} & set(living()))
    client.cancel_plan(running.id)
    job = client.submit_plan(request_of(client.add_scene(ARM)))
    list(client.plan_events(job.id))
    assert client.plan(job.id).state == "succeeded"
    assert client.plan(running.id).state == "canceled"


def test_a_helper_that_dies_does_not_end_its_plan(real_server, client, running, helpers):
    assert len(helpers) <= 3
    lost = min(helpers)
    os.kill(lost, signal.SIGKILL)
    until(lambda: lost not in helpers_of(real_server.process.pid))
    assert client.plan(running.id).state == "running"
