"""A job of a lost machine runs elsewhere, if it may run twice and does not take them with it."""

import asyncio
from dataclasses import dataclass

import pytest

from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.lost_hosts import MAX_LOST_HOSTS
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.outcome import Lost, Returned, returned
from service.jobs.states import JobState
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from tests.service.jobs.conftest import GUARD, spec


class Fated:
    """A worker whose runs end as they are fated to."""

    generation = 0
    fault = None
    is_lost = False

    def __init__(self, *outcomes):
        self.outcomes = list(outcomes)

    async def open(self, warm_up):
        pass

    async def ready(self):
        pass

    async def bring(self, artifacts):
        pass

    async def run(self, run):
        return self.outcomes.pop(0)

    def cancel(self, grace):
        pass

    def control(self, controls):
        pass

    async def close(self):
        pass


BEGUN, NOT_BEGUN = Lost("there", has_begun=True), Lost("there", has_begun=False)
DONE = returned("", "{}")


@dataclass(frozen=True)
class Case:
    outcomes: list
    max_attempts: int
    end: str


CASES = {
    "runs again": Case([BEGUN, DONE], 2, "succeeded"),
    "no attempt, twice": Case([BEGUN, BEGUN, DONE], 2, "succeeded"),
    "too often": Case([BEGUN] * MAX_LOST_HOSTS, 2, "host_lost"),
    "but once": Case([BEGUN], 1, "host_lost"),
    "but once, not begun": Case([NOT_BEGUN, DONE], 1, "succeeded"),
    "never begun": Case([NOT_BEGUN] * 2 * MAX_LOST_HOSTS + [DONE], 2, "succeeded"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_job_of_a_lost_machine(tmp_path, name):
    case = CASES[name]

    async def story():
        engine = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
        store = JobStore(engine)
        queue = JobQueue("plan", [Fated(*case.outcomes)], 10)
        dispatcher = Dispatcher(store, DispatcherLock(engine), {"plan": queue})
        await dispatcher.start()
        job = await dispatcher.submit(spec("echo", max_attempts=case.max_attempts))
        ended = await dispatcher.wait(job.id, GUARD)
        await dispatcher.stop()
        engine.dispose()
        is_done = isinstance(case.outcomes[-1], Returned)
        assert (ended.state is JobState.SUCCEEDED) is is_done
        assert (ended.failure or {"code": ended.state})["code"] == case.end
        if is_done:
            assert ended.attempts == 1  # what was lost does not count

    asyncio.run(story())
