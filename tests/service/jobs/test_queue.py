"""Who gets which slot: order, priority, warmth, and that nobody waits for ever."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.queue import SHORT, CallKind, JobQueue, QueueEntry, Share
from service.jobs.worker_pool import WorkerPool


class Place:
    """Stands for a slot; lanes look at nothing else of one."""

    generation = 0


def lane_of(num_slots, *, warm_wait=0.1, idle=True):
    lane = JobQueue("plan", [Place() for _ in range(num_slots)], 10, warm_wait=warm_wait)
    if idle:
        for slot in lane.pool.workers:
            lane.pool.give_back(slot)
    return lane


def free(lane, slot, seconds=None):
    """The run in a slot has ended, and the slot is ready again."""
    lane.end_run(slot, seconds)
    lane.pool.give_back(slot)


def wait(lane, name, key=None, priority=0, since=0.0, kind=None):
    lane.add(QueueEntry(name, key, priority, since, lambda _: None, lane.next_order(), kind))


def names(assignments):
    return [ticket.name for ticket, _ in assignments.pairs]


def test_first_come_first_served_within_a_priority():
    lane = lane_of(1, idle=False)
    for name, priority in (("a", 0), ("b", 0), ("c", 5), ("d", 5)):
        wait(lane, name, priority=priority)
    served = []
    for _ in range(4):
        free(lane, lane.pool.workers[0])
        served += names(lane.assign(0.0))
    assert served == ["c", "d", "a", "b"]


def test_who_comes_again_keeps_its_place():
    lane = lane_of(1)
    wait(lane, "a")
    [(again, slot)] = lane.assign(0.0).pairs
    wait(lane, "b")
    lane.add(again)
    free(lane, slot)
    assert names(lane.assign(0.0)) == ["a"]


def test_a_warm_slot_is_preferred():
    lane = lane_of(3)
    wait(lane, "a", "scene")
    [(_, warm)] = lane.assign(0.0).pairs
    free(lane, warm)
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
    free(lane, next(slot for slot in lane.pool.workers if slot is not warm))
    decided = lane.assign(1.05)
    assert names(decided) == []
    assert decided.decide_again == pytest.approx(1.1)
    assert names(lane.assign(1.11)) == ["b"]


def test_a_slot_whose_process_is_another_is_cold():
    lane = lane_of(2)
    wait(lane, "a", "scene")
    [(_, slot)] = lane.assign(0.0).pairs
    slot.generation += 1
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


def lanes_of(**shares):
    """Lanes of one pool that has just as many slots as they may use, all idle."""
    pool = WorkerPool([Place() for _ in range(sum(share.max_running for share in shares.values()))])
    for slot in pool.workers:
        pool.give_back(slot)
    return [JobQueue(name, pool, 10, share=share) for name, share in shares.items()]


def test_a_lane_leaves_to_another_one_what_that_may_use():
    plans, questions = lanes_of(plan=Share(1), query=Share(2))
    for i in range(3):
        wait(plans, f"p{i}")
        wait(questions, f"q{i}", kind=CallKind("echo"))
    assert names(questions.assign(0.0)) == ["q0", "q1"]
    assert names(plans.assign(0.0)) == ["p0"]


def test_what_a_question_has_loaded_is_warm_for_the_first_plan():
    plans, questions = lanes_of(plan=Share(1), query=Share(2))
    wait(questions, "post", kind=CallKind("load", is_load=True))
    [(_, slot)] = questions.assign(0.0).pairs
    plans.pool.warm(slot, "scene")
    free(questions, slot)
    wait(plans, "first", "scene")
    assert plans.assign(0.0).pairs[0][1] is slot


def test_a_slot_is_kept_for_what_is_short():
    (lane,) = lanes_of(query=Share(2, reserved=1))
    for name in ("large", "larger"):
        wait(lane, name, kind=CallKind("load", is_load=True))
    wait(lane, "short", kind=CallKind("echo"))
    assert names(lane.assign(0.0)) == ["large", "short"]


def test_a_scene_that_has_to_be_loaded_first_does_not_get_the_kept_slot():
    (lane,) = lanes_of(query=Share(2, reserved=1))
    wait(lane, "cold", "scene", kind=CallKind("check"))
    [(_, slot)] = lane.assign(0.0).pairs
    wait(lane, "too", "scene", since=0.0, kind=CallKind("check"))
    assert names(lane.assign(1.0)) == []  # the idle slot would load it for as long
    free(lane, slot, 60.0)
    assert lane.assign(1.0).pairs[0][1] is slot


@pytest.mark.parametrize(("took", "served"), [(SHORT / 2, ["b"]), (2 * SHORT, [])])
def test_what_ran_long_is_long_the_next_time(took, served):
    (lane,) = lanes_of(query=Share(2, reserved=1))
    for slot in lane.pool.workers:
        lane.pool.warm(slot, "scene")
    wait(lane, "first", "scene", kind=CallKind("check", 14))
    [(_, slot)] = lane.assign(0.0).pairs
    free(lane, slot, took)
    wait(lane, "load", kind=CallKind("load", is_load=True))
    lane.assign(0.0)
    wait(lane, "b", "scene", kind=CallKind("check", 14))
    wait(lane, "small", "scene", kind=CallKind("check", 1))
    assert names(lane.assign(0.0)) == (served or ["small"])


def test_a_small_scene_may_be_loaded_anew_by_the_kept_slot():
    (lane,) = lanes_of(query=Share(2, reserved=1))
    lane.durations.record_load("small", SHORT / 2)
    wait(lane, "load", kind=CallKind("load", is_load=True))
    lane.assign(0.0)
    wait(lane, "cold", "small", kind=CallKind("check"))
    assert names(lane.assign(0.0)) == ["cold"]


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
            free(lane, busy.pop(0), 0.1)
        look()
    now += 1.0
    look()
    for _ in range(len(came) - len(served)):  # each frees a slot, and somebody gets it
        num_served = len(served)
        free(lane, busy.pop(0))
        look()
        assert len(served) == num_served + 1
    assert sorted(served) == sorted(came)
