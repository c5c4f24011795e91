"""The record against a model: whatever happens in whatever order, it stays consistent."""

import tempfile
import threading

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, rule

from planning.errors import Canceled, NoPathFound
from service.jobs.errors import IdempotencyConflict, UnknownJob
from service.jobs.job import JobSpec
from service.jobs.json_text import Encoded, encode
from service.jobs.states import JobState
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from tests.profiles import num_cases
from tests.service.jobs.one_at_a_time import NUM_SERVERS, check_one_at_a_time

CANCELED = Canceled("on request")
NO_PATH = NoPathFound("none", {"attempts": 3})


@pytest.fixture
def engine(tmp_path):
    made = open_engine(f"sqlite:///{tmp_path / 'deep' / 'jobs.sqlite'}")
    yield made
    made.dispose()


@pytest.fixture
def store(engine):
    opened = JobStore(engine)
    opened.open()
    return opened


def spec(**fields):
    return JobSpec(**{"queue": "plan", "task": "m:f", "payload": {"x": 0.1 + 0.2}, **fields})


def add(store, **fields):
    job, is_new = store.insert(spec(**fields))
    assert is_new
    return job


def test_a_job_is_as_it_was_asked_for(store, engine):
    job = add(store, prefix="pln", scene="s", world_digest="w", priority=3, time_limit=1.5, key="k")
    assert job.id.startswith("pln_")
    assert len(job.id) >= 20
    again = JobStore(engine).get(job.id)
    assert again == job
    assert again.payload == {"x": 0.1 + 0.2}
    assert again.created_at.utcoffset().total_seconds() == 0
    assert (again.state, again.attempts, again.progress) == (JobState.QUEUED, 0, 0.0)
    assert again.result is again.failure is again.started_at is again.finished_at is None
    with pytest.raises(UnknownJob, match="job_x"):
        store.get("job_x")


def test_the_same_key_and_request_give_the_same_job(store):
    first = add(store, key="k", request_digest="1")
    assert store.insert(spec(key="k", request_digest="1")) == (first, False)
    assert store.find_by_key("plan", "k", "1") == first
    assert store.find_by_key("plan", "other", "1") is None
    for ask in (lambda: store.insert(spec(key="k")), lambda: store.find_by_key("plan", "k", "2")):
        with pytest.raises(IdempotencyConflict) as refusal:
            ask()
        assert refusal.value.evidence == {"key": "k", "job": first.id}
    assert add(store, key="k", queue="execution").id != first.id
    assert add(store).id != add(store).id


def test_a_key_used_by_many_at_once_names_one_job(store):
    found = []

    def submit():
        found.append(store.insert(spec(key="k")))

    threads = [threading.Thread(target=submit) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({job.id for job, _ in found}) == 1
    assert sum(is_new for _, is_new in found) == 1


def test_one_execution_of_a_robot_is_open_at_most(engine):
    engines = [engine, *(open_engine(str(engine.url)) for _ in range(NUM_SERVERS - 1))]
    check_one_at_a_time(engines)
    for other in engines[1:]:
        other.dispose()


def test_pages_join_up_and_filter(store):
    ids = [add(store, scene=f"s{i % 2}", queue="plan").id for i in range(7)]
    add(store, queue="execution")
    store.start(ids[3])
    seen, before = [], None
    while page := store.page("plan", before=before, limit=3):
        seen += [job.id for job in page]
        before = page[-1].sequence
    assert seen == ids[::-1]
    assert [job.id for job in store.page("plan", {"state": "running"})] == [ids[3]]
    assert [job.id for job in store.page("plan", {"scene": "s1", "state": "queued"})] == [
        ids[5],
        ids[1],
    ]
    counts = store.counts()
    assert counts == {
        ("plan", "queued"): 6,
        ("plan", "running"): 1,
        ("execution", "queued"): 1,
    }
    assert [job.id for job in store.unfinished()][:7] == ids


def test_events_carry_stage_and_progress_into_the_job(store):
    job = add(store)
    assert store.append_events(job.id, [("stage", Encoded('{"stage":"early"}'))]) == []
    store.start(job.id)
    told = [
        ("stage", Encoded('{"stage":"search","progress":0.25}')),
        ("progress", Encoded('{"progress":7}')),
        ("note", Encoded('{"stage":5,"progress":"x"}')),
    ]
    assert [event.number for event in store.append_events(job.id, told)] == [3, 4, 5]
    now = store.get(job.id)
    assert (now.stage, now.progress) == ("search", 1.0)
    assert store.last_event(job.id, "progress").data == {"progress": 7}
    assert store.last_event(job.id, "nothing") is None
    store.fail(job.id, NO_PATH)
    assert store.append_events(job.id, told) == []
    assert [event.number for event in store.events(job.id, 4)] == [5, 6]
    assert store.events_after(job.id, 5).is_over
    with pytest.raises(UnknownJob):
        store.events_after("job_x", 0)


@given(
    st.lists(
        st.fixed_dictionaries(
            {},
            optional={
                "stage": st.sampled_from(["goals", "search", 5]),
                "progress": st.sampled_from([0, 0.25, 7, -1, "x"]),
            },
        ),
        max_size=6,
    )
)
@example([{"stage": "goals"}, {"stage": "search"}])
@settings(max_examples=num_cases(20), deadline=None)
def test_last_events_written_with_a_success_are_as_those_before_it(told):
    events = [("note", Encoded(encode(data))) for data in told]
    with tempfile.TemporaryDirectory() as folder:
        engine = open_engine(f"sqlite:///{folder}/jobs.sqlite")
        store = JobStore(engine)
        store.open()
        ends = []
        for before, with_it in ((events, ()), ((), events)):
            job = add(store)
            store.start(job.id)
            logged = store.append_events(job.id, before)
            end = store.succeed(job.id, Encoded("{}"), None, with_it)
            logged += [*end.events_before, end.event]
            whole = store.get(job.id)
            assert [event.number for event in logged] == list(range(3, len(told) + 4))
            assert [(e.number, e.data) for e in store.events(job.id, 2)] == [
                (e.number, e.data) for e in logged
            ]
            assert [event.type for event in logged] == [*("note" for _ in told), "finished"]
            stages = [data["stage"] for data in told if isinstance(data.get("stage"), str)]
            assert whole.stage == (stages or [""])[-1]
            ends.append((whole.stage, whole.progress, whole.num_events, whole.state))
        assert ends[0] == ends[1]
        assert ends[0][1] == 1.0
        engine.dispose()


def test_a_kept_connection_is_closed_after_a_fault_and_at_the_end(store, engine):
    class Fault(Exception):
        pass

    def used():
        with store.transaction(is_durable=True) as connection:
            return connection

    def fail():
        with store.transaction(is_durable=True) as connection:
            add(store)
            raise Fault(connection)

    apart = used()
    assert apart.closed
    with store.keeping_connection():
        first = used()
        assert used() is first
        assert not first.closed
        with pytest.raises(Fault):
            fail()
        assert first.closed
        again = used()
        assert again is not first
        job = add(store)
        assert JobStore(engine).get(job.id) == job
    assert again.closed
    assert engine.pool.checkedout() == 0
    assert [job.id for job in store.unfinished()] == [job.id]


def test_a_failed_transaction_leaves_nothing(store):
    job = add(store)

    def give_up():
        with store.transaction(is_durable=False):
            assert store.start(job.id) is not None
            raise RuntimeError

    with pytest.raises(RuntimeError):
        give_up()
    assert store.get(job.id) == job
    assert len(store.events(job.id)) == 1


class Jobs(RuleBasedStateMachine):
    """A store and the same thing in a dictionary."""

    ids = Bundle("ids")

    def __init__(self):
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.engine = open_engine(f"sqlite:///{self.folder.name}/jobs.sqlite")
        self.store = JobStore(self.engine)
        self.store.open()
        self.model = {}

    def teardown(self):
        self.engine.dispose()
        self.folder.cleanup()

    @rule(target=ids)
    def insert(self):
        job, _ = self.store.insert(spec())
        self.model[job.id] = {"state": "queued", "attempts": 0, "wanted": True, "events": 1}
        return job.id

    def moved(self, identifier, moved, before, after, **changes):
        model = self.model[identifier]
        assert (moved is not None) == (model["state"] in before)
        if moved is not None:
            model |= {"state": after, "events": model["events"] + 1, **changes}
            assert moved.event.number == model["events"]
            assert moved.attempts == model["attempts"]
            assert moved.is_cancel_requested != model["wanted"]

    @rule(identifier=ids)
    def start(self, identifier):
        attempts = self.model[identifier]["attempts"] + 1
        moved = self.store.start(identifier)
        self.moved(identifier, moved, {"queued"}, "running", attempts=attempts)

    @rule(identifier=ids, refund=st.integers(0, 1))
    def requeue(self, identifier, refund):
        attempts = self.model[identifier]["attempts"] - refund
        moved = self.store.requeue(identifier, "because", refund=refund)
        self.moved(identifier, moved, {"running"}, "queued", attempts=attempts)

    @rule(identifier=ids)
    def succeed(self, identifier):
        moved = self.store.succeed(identifier, Encoded('{"y":2}'))
        self.moved(identifier, moved, {"running"}, "succeeded")

    @rule(identifier=ids)
    def fail(self, identifier):
        moved = self.store.fail(identifier, NO_PATH)
        self.moved(identifier, moved, {"queued", "running"}, "failed")

    @rule(identifier=ids)
    def cancel(self, identifier):
        moved = self.store.cancel(identifier, CANCELED)
        self.moved(identifier, moved, {"queued", "running"}, "canceled")

    @rule(identifier=ids)
    def cancel_queued(self, identifier):
        moved = self.store.cancel_queued(identifier, CANCELED)
        self.moved(identifier, moved, {"queued"}, "canceled")

    @rule(identifier=ids)
    def request_cancel(self, identifier):
        job = self.store.request_cancel(identifier)
        if not job.state.is_final:
            self.model[identifier]["wanted"] = False

    @rule(identifier=ids, count=st.integers(0, 3))
    def record(self, identifier, count):
        logged = self.store.append_events(identifier, [("note", Encoded("{}"))] * count)
        model = self.model[identifier]
        first = model["events"] + 1
        model["events"] += count if model["state"] == "running" else 0
        assert [event.number for event in logged] == list(range(first, model["events"] + 1))

    @invariant()
    def agree(self):
        for identifier, model in self.model.items():
            job = self.store.get(identifier)
            assert job.state == model["state"]
            assert job.attempts == model["attempts"]
            assert job.is_cancel_requested != model["wanted"]
            assert job.num_events == model["events"]
            events = self.store.events(identifier)
            assert [event.number for event in events] == list(range(1, model["events"] + 1))
            assert [e.is_last for e in events] == [False] * (len(events) - 1) + [job.state.is_final]
            assert (job.result == {"y": 2}) == (job.state == "succeeded")
            assert (job.failure is not None) == (job.state in {"failed", "canceled"})
            assert (job.finished_at is not None) == job.state.is_final


Jobs.TestCase.settings = settings(max_examples=num_cases(6), stateful_step_count=20)
TestJobs = Jobs.TestCase
