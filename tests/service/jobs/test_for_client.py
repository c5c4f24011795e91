"""What is requested through the service of a client is that client's, and of no other one."""

import asyncio

import pytest

from service.catalog.planners import known_planners
from service.catalog.tasks import LIST_PLANNERS, NoWork
from service.jobs.dispatch.calls import CallResult
from service.jobs.job import JobSpec
from service.jobs.service import JobService


class Recorder:
    """Stands for a dispatcher; keeps what it is handed."""

    def __init__(self):
        self.handed = []

    async def call(self, call):
        self.handed.append(call)
        return CallResult({"items": []}, 0.0, 0.0)

    async def submit(self, spec):
        self.handed.append(spec)


@pytest.fixture
def dispatcher():
    return Recorder()


@pytest.fixture
def jobs(dispatcher):
    return JobService(None, dispatcher, prefixes={}, queues=())  # pyright: ignore[reportArgumentType]


def test_jobs_and_calls_are_those_of_the_client(jobs, dispatcher):
    async def story():
        for each in (jobs.for_client("a"), jobs.for_client("b"), jobs):
            await each.submit(JobSpec("plan", "", {}))
            await each.call(LIST_PLANNERS, NoWork())

    asyncio.run(story())
    assert [each.client for each in dispatcher.handed] == ["a", "a", "b", "b", "", ""]


def test_what_never_changes_is_asked_once_for_all_clients(jobs, dispatcher):
    async def story():
        for client in "aba":
            await known_planners(jobs.for_client(client))

    asyncio.run(story())
    assert len(dispatcher.handed) == 1
