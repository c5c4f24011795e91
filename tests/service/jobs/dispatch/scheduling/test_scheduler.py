"""What is said of workers that are not ready."""

from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.dispatch.scheduling.scheduler import Scheduler
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
