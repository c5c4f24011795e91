"""Who gets which worker: order, priority, warmth, and that none waits without end."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.dispatch.scheduling.durations import SHORT, CallKind
from service.jobs.dispatch.scheduling.queue import Share
from tests.service.jobs.dispatch.queues import free, names, queue_of, queues_of, wait


def test_first_come_first_served_within_a_priority():
    queue = queue_of(1, idle=False)
    for name, priority in (("a", 0), ("b", 0), ("c", 5), ("d", 5)):
        wait(queue, name, priority=priority)
    served = []
    for _ in range(4):
        free(queue, queue.pool.workers[0])
        served += names(queue.assign(0.0))
    assert served == ["c", "d", "a", "b"]


def test_who_comes_again_keeps_its_place():
    queue = queue_of(1)
    wait(queue, "a")
    [(again, worker)] = queue.assign(0.0).pairs
    wait(queue, "b")
    queue.add(again)
    free(queue, worker)
    assert names(queue.assign(0.0)) == ["a"]


def test_a_warm_worker_is_preferred():
    queue = queue_of(3)
    wait(queue, "a", "scene")
    [(_, warm)] = queue.assign(0.0).pairs
    free(queue, warm)
    wait(queue, "b", "other")
    wait(queue, "c", "scene")
    pairs = {entry.name: worker for entry, worker in queue.assign(0.0).pairs}
    assert pairs["c"] is warm
    assert pairs["b"] is not warm


def test_a_busy_warm_worker_is_waited_for_but_not_long():
    queue = queue_of(2, warm_wait=0.1)
    wait(queue, "a", "scene")
    [(_, warm)] = queue.assign(0.0).pairs
    wait(queue, "b", "scene", since=1.0)
    wait(queue, "c", "other", since=1.0)
    decided = queue.assign(1.0)
    assert names(decided) == ["c"]
    free(queue, next(worker for worker in queue.pool.workers if worker is not warm))
    decided = queue.assign(1.05)
    assert names(decided) == []
    assert decided.decide_again == pytest.approx(1.1)
    assert names(queue.assign(1.11)) == ["b"]


def test_a_worker_whose_process_is_another_is_cold():
    queue = queue_of(2)
    wait(queue, "a", "scene")
    [(_, worker)] = queue.assign(0.0).pairs
    worker.generation += 1
    wait(queue, "b", "scene")
    assert names(queue.assign(0.0)) == ["b"]  # does not wait for it


def test_admission_and_the_advice_when_to_come_again():
    queue = queue_of(2, idle=False)
    advice = []
    for i in range(10):
        assert queue.has_room()
        wait(queue, str(i))
        advice.append(queue.retry_after(0.0))
    assert not queue.has_room()
    assert advice == sorted(advice)
    assert all(1 <= seconds <= 60 for seconds in advice)
    queue.remove("3")
    assert queue.has_room()


def test_no_client_fills_a_queue():
    queue = queue_of(2, idle=False)  # ten may wait
    for i in range(9):
        assert queue.has_room(1, "one")
        wait(queue, str(i), client="one")
    assert not queue.has_room(1, "one")
    assert queue.has_room(1, "other")
    wait(queue, "9", client="other")
    assert not queue.has_room(1, "third")
    queue.remove("9")
    assert queue.has_room(1, "other")


def test_a_queue_leaves_to_another_one_what_that_may_use():
    plans, questions = queues_of(plan=Share(1), query=Share(2))
    for i in range(3):
        wait(plans, f"p{i}")
        wait(questions, f"q{i}", kind=CallKind("echo"))
    assert names(questions.assign(0.0)) == ["q0", "q1"]
    assert names(plans.assign(0.0)) == ["p0"]


def test_what_a_question_has_loaded_is_warm_for_the_first_plan():
    plans, questions = queues_of(plan=Share(1), query=Share(2))
    wait(questions, "post", kind=CallKind("load", is_load=True))
    [(_, worker)] = questions.assign(0.0).pairs
    plans.pool.warm(worker, "scene")
    free(questions, worker)
    wait(plans, "first", "scene")
    assert plans.assign(0.0).pairs[0][1] is worker


def test_a_worker_is_kept_for_what_is_short():
    (queue,) = queues_of(query=Share(2, reserved=1))
    for name in ("large", "larger"):
        wait(queue, name, kind=CallKind("load", is_load=True))
    wait(queue, "short", kind=CallKind("echo"))
    assert names(queue.assign(0.0)) == ["large", "short"]


def test_a_scene_that_has_to_be_loaded_first_does_not_get_the_kept_worker():
    (queue,) = queues_of(query=Share(2, reserved=1))
    wait(queue, "cold", "scene", kind=CallKind("check"))
    [(_, worker)] = queue.assign(0.0).pairs
    wait(queue, "too", "scene", since=0.0, kind=CallKind("check"))
    assert names(queue.assign(1.0)) == []  # the idle worker would load it for as long
    free(queue, worker, 60.0)
    assert queue.assign(1.0).pairs[0][1] is worker


@pytest.mark.parametrize(("took", "served"), [(SHORT / 2, ["b"]), (2 * SHORT, [])])
def test_what_ran_long_is_long_the_next_time(took, served):
    (queue,) = queues_of(query=Share(2, reserved=1))
    for worker in queue.pool.workers:
        queue.pool.warm(worker, "scene")
    wait(queue, "first", "scene", kind=CallKind("check", 14))
    [(_, worker)] = queue.assign(0.0).pairs
    free(queue, worker, took)
    wait(queue, "load", kind=CallKind("load", is_load=True))
    queue.assign(0.0)
    wait(queue, "b", "scene", kind=CallKind("check", 14))
    wait(queue, "small", "scene", kind=CallKind("check", 1))
    assert names(queue.assign(0.0)) == (served or ["small"])


def test_a_small_scene_may_be_loaded_anew_by_the_kept_worker():
    (queue,) = queues_of(query=Share(2, reserved=1))
    queue.durations.record_load("small", SHORT / 2)
    wait(queue, "load", kind=CallKind("load", is_load=True))
    queue.assign(0.0)
    wait(queue, "cold", "small", kind=CallKind("check"))
    assert names(queue.assign(0.0)) == ["cold"]


@given(
    st.lists(
        st.tuples(st.sampled_from(["come", "tick", "free"]), st.integers(0, 3), st.integers(0, 2)),
        max_size=60,
    )
)
def test_each_is_served_once_and_workers_are_never_shared(steps):
    queue = queue_of(2)
    now, came, served, busy = 0.0, [], [], []

    def look():
        for entry, worker in queue.assign(now).pairs:
            assert worker not in busy
            busy.append(worker)
            served.append(entry.name)

    for i, (what, key, priority) in enumerate(steps):
        if what == "come":
            came.append(str(i))
            wait(queue, str(i), f"k{key}", now, priority=priority)
        elif what == "tick":
            now += 0.06
        elif busy:
            free(queue, busy.pop(0), 0.1)
        look()
    now += 1.0
    look()
    for _ in range(len(came) - len(served)):  # each frees a worker, and the next one gets it
        num_served = len(served)
        free(queue, busy.pop(0))
        look()
        assert len(served) == num_served + 1
    assert sorted(served) == sorted(came)
