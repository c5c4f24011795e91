"""Who gets which slot: order, priority, warmth, and that nobody waits for ever."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.lane import Lane, Ticket


class Place:
    """Stands for a slot; lanes never look into one."""


def lane_of(num_slots, *, warm_wait=0.1, idle=True):
    lane = Lane("plan", [Place() for _ in range(num_slots)], 10, warm_wait=warm_wait)
    if idle:
        for slot in lane.slots:
            lane.give_back(slot)
    return lane


def wait(lane, name, key=None, priority=0, since=0.0):
    lane.add(Ticket(name, key, priority, since, lambda _: None, lane.next_order()))


def names(assignments):
    return [ticket.name for ticket, _ in assignments.pairs]


def test_first_come_first_served_within_a_priority():
    lane = lane_of(1, idle=False)
    for name, priority in (("a", 0), ("b", 0), ("c", 5), ("d", 5)):
        wait(lane, name, priority=priority)
    served = []
    for _ in range(4):
        lane.give_back(lane.slots[0])
        served += names(lane.assign(0.0))
    assert served == ["c", "d", "a", "b"]


def test_who_comes_again_keeps_its_place():
    lane = lane_of(1)
    wait(lane, "a")
    [(again, slot)] = lane.assign(0.0).pairs
    wait(lane, "b")
    lane.add(again)
    lane.give_back(slot)
    assert names(lane.assign(0.0)) == ["a"]


def test_a_warm_slot_is_preferred():
    lane = lane_of(3)
    wait(lane, "a", "scene")
    [(_, warm)] = lane.assign(0.0).pairs
    lane.give_back(warm)
    wait(lane, "b", "other")
    wait(lane, "c", "scene")
    pairs = {ticket.name: slot for ticket, slot in lane.assign(0.0).pairs}
    assert pairs["c"] is warm
    assert pairs["b"] is not warm


def test_a_busy_warm_slot_is_waited_for_but_not_long():
    lane = lane_of(2, warm_wait=0.1)
    wait(lane, "a", "scene")
    [(_, warm)] = lane.assign(0.0).pairs
    wait(lane, "b", "scene", since=1.0)
    wait(lane, "c", "other", since=1.0)
    decided = lane.assign(1.0)
    assert names(decided) == ["c"]
    lane.give_back(next(slot for slot in lane.slots if slot is not warm))
    decided = lane.assign(1.05)
    assert names(decided) == []
    assert decided.look_again == pytest.approx(1.1)
    assert names(lane.assign(1.11)) == ["b"]


def test_a_slot_whose_process_is_another_is_cold():
    lane = lane_of(2)
    wait(lane, "a", "scene")
    [(_, slot)] = lane.assign(0.0).pairs
    lane.cool(slot)
    wait(lane, "b", "scene")
    assert names(lane.assign(0.0)) == ["b"]  # does not wait for it


def test_admission_and_the_advice_when_to_come_again():
    lane = lane_of(2, idle=False)
    advice = []
    for i in range(10):
        assert not lane.is_full
        wait(lane, str(i))
        advice.append(lane.retry_after)
    assert lane.is_full
    assert advice == sorted(advice)
    assert all(1 <= seconds <= 60 for seconds in advice)
    lane.remove("3")
    assert not lane.is_full


@given(
    st.lists(
        st.tuples(st.sampled_from(["come", "tick", "free"]), st.integers(0, 3), st.integers(0, 2)),
        max_size=60,
    )
)
def test_everybody_is_served_once_and_slots_are_never_shared(steps):
    lane = lane_of(2)
    now, came, served, busy = 0.0, [], [], []

    def look():
        for ticket, slot in lane.assign(now).pairs:
            assert slot not in busy
            busy.append(slot)
            served.append(ticket.name)

    for i, (what, key, priority) in enumerate(steps):
        if what == "come":
            came.append(str(i))
            wait(lane, str(i), f"k{key}", priority, now)
        elif what == "tick":
            now += 0.06
        elif busy:
            lane.give_back(busy.pop(0), 0.1)
        look()
    now += 1.0
    look()
    for _ in range(len(came) - len(served)):  # each frees a slot, and somebody gets it
        num_served = len(served)
        lane.give_back(busy.pop(0))
        look()
        assert len(served) == num_served + 1
    assert sorted(served) == sorted(came)
