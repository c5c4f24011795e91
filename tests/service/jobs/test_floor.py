"""What is said of slots that are not ready."""

from service.jobs.floor import Floor
from service.jobs.lane import Lane
from service.jobs.pool import Pool


class Place:
    """Stands for a slot, of which only its fault is looked at."""

    generation = 0

    def __init__(self, fault=None):
        self.fault = fault


def test_a_lane_is_at_fault_when_none_of_its_slots_is_well():
    shared = Pool([Place("cold"), Place()])
    own = Pool([Place("cannot import"), Place("cold")])
    lanes = [Lane("plan", shared, 1), Lane("query", shared, 1), Lane("execution", own, 1)]
    floor = Floor({lane.name: lane for lane in lanes})
    assert floor.faults() == {"execution": "cannot import"}
    shared.slots[1].fault = "died"
    assert floor.faults() == {"plan": "cold", "query": "cold", "execution": "cannot import"}
