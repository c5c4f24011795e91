"""What is said of workers that are not ready, and when those that were given back are used."""

import asyncio

from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.dispatch.scheduling.scheduler import Scheduler
from service.jobs.dispatch.scheduling.waiting import QueueEntry
from service.jobs.dispatch.scheduling.worker_pool import WorkerPool


class Place:
    """Stands for a worker, of which only its fault is looked at."""

    generation = 0

    def __init__(self, fault=None):
        self.fault = fault


def test_a_queue_is_at_fault_when_none_of_its_workers_is_well():
    shared = WorkerPool([Place("cold"), Place()])
    own = WorkerPool([Place("cannot import"), Place("cold")])
    queues = [
        JobQueue("plan", shared, 1),
        JobQueue("query", shared, 1),
        JobQueue("execution", own, 1),
    ]
    scheduler = Scheduler({queue.name: queue for queue in queues})
    assert scheduler.faults() == {"execution": "cannot import"}
    shared.workers[1].fault = "died"
    assert scheduler.faults() == {"plan": "cold", "query": "cold", "execution": "cannot import"}


class ReadyPlace(Place):
    """Stands for a worker that is always ready."""

    is_lost = False

    def __init__(self):
        super().__init__()
        self.was_asked = asyncio.Event()

    async def open(self, warm_up):
        del warm_up

    async def ready(self):
        self.was_asked.set()

    async def close(self):
        pass


async def with_one_worker(story):
    """Do something with a scheduler of one worker that is idle; close it afterwards."""
    worker = ReadyPlace()
    scheduler = Scheduler({"plan": JobQueue("plan", [worker], 9)})
    await scheduler.open(None)
    await asyncio.sleep(0)
    try:
        await story(scheduler, worker)
    finally:
        await scheduler.close()


def entry_of(scheduler, name, used):
    """Return an entry that notes its name when it gets a worker."""
    return QueueEntry(name, scheduler.next_place("plan"), lambda _: used.append(name))


def test_a_worker_that_is_given_back_is_used_by_what_waits_and_by_what_comes():
    async def story(scheduler, worker):
        used = []
        for name in ("first", "second"):
            scheduler.request("plan", entry_of(scheduler, name, used))
        assert used == ["first"]
        scheduler.release("plan", worker, 0.1)
        await asyncio.sleep(0)
        assert used == ["first", "second"]
        scheduler.release("plan", worker, 0.1)  # and nothing waits
        scheduler.request("plan", entry_of(scheduler, "third", used))
        await asyncio.sleep(0)
        assert used == ["first", "second", "third"]

    asyncio.run(with_one_worker(story))


def test_a_worker_is_looked_after_when_nothing_comes():
    async def story(scheduler, worker):
        used = []
        scheduler.request("plan", entry_of(scheduler, "first", used))
        scheduler.release("plan", worker, 0.1)
        worker.was_asked.clear()
        await asyncio.wait_for(worker.was_asked.wait(), 60)
        assert scheduler.queue("plan").pool.has_idle

    asyncio.run(with_one_worker(story))


def test_work_that_begins_does_its_first_step_at_once():
    async def story(scheduler, _):
        steps = []

        async def work():
            steps.append("first")
            await asyncio.sleep(0)
            steps.append("second")

        scheduler.begin(work())
        assert steps == ["first"]
        await asyncio.sleep(0)
        assert steps == ["first", "second"]

    asyncio.run(with_one_worker(story))
