"""What is said of slots that are not ready."""

from service.jobs.queue import JobQueue
from service.jobs.scheduler import Scheduler
from service.jobs.worker_pool import WorkerPool


class Place:
    """Stands for a slot, of which only its fault is looked at."""

    generation = 0

    def __init__(self, fault=None):
        self.fault = fault


def test_a_lane_is_at_fault_when_none_of_its_slots_is_well():
    shared = WorkerPool([Place("cold"), Place()])
    own = WorkerPool([Place("cannot import"), Place("cold")])
    lanes = [
        JobQueue("plan", shared, 1),
        JobQueue("query", shared, 1),
        JobQueue("execution", own, 1),
    ]
    floor = Scheduler({lane.name: lane for lane in lanes})
    assert floor.faults() == {"execution": "cannot import"}
    shared.workers[1].fault = "died"
    assert floor.faults() == {"plan": "cold", "query": "cold", "execution": "cannot import"}
