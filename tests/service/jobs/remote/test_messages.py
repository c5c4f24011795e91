"""What a host and the dispatcher say to each other arrives as it was said, or is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.errors import Canceled, DeadlineExceeded, GoalUnreachable, WayproofError
from service.jobs.hosts.messages import (
    BATCH,
    HostMessage,
    HostMessageKind,
    batch_of,
    pack,
    unpack,
)
from service.jobs.hosts.outcome_text import dump_outcome, load_outcome
from service.jobs.hosts.plan import HostPlan, HostTimeouts
from service.jobs.json_text import Encoded
from service.jobs.outcome import (
    Crashed,
    Lost,
    MemoryExceeded,
    Raised,
    Returned,
    Silent,
    Terminated,
    TimedOut,
)
from service.jobs.worker.main import Terms
from service.jobs.worker.protocol import RemoteFailure, dump_error, load_error
from service.telemetry.logs import LogTerms

MESSAGES = st.builds(
    HostMessage,
    st.sampled_from(HostMessageKind),
    st.integers(0, 2**32 - 1),
    st.integers(0, 2**64 - 1),
    st.binary(max_size=100),
)


@given(st.lists(MESSAGES, max_size=6))
def test_messages_cross_as_they_are(messages):
    assert unpack(pack(messages)) == messages


@given(st.lists(MESSAGES, min_size=1, max_size=3), st.data())
def test_what_is_cut_off_is_refused(messages, data):
    whole = pack(messages)
    ends = {len(pack(messages[:count])) for count in range(len(messages))}
    cut = data.draw(st.integers(1, len(whole) - 1).filter(lambda place: place not in ends))
    with pytest.raises(ValueError, match="a message"):
        unpack(whole[:cut])


def test_a_kind_that_there_is_not_and_a_length_beyond_all_bounds_are_refused():
    with pytest.raises(ValueError, match="HostMessageKind"):
        unpack(b"\0\0\0\0\x63" + b"\0" * 12)
    with pytest.raises(ValueError, match="a message of 4294967295 bytes"):
        unpack(b"\xff\xff\xff\xff\x01" + b"\0" * 12)


@given(st.lists(st.integers(0, 2 * BATCH), max_size=8))
def test_batches_are_small_and_lose_nothing(sizes):
    waiting = [HostMessage(HostMessageKind.EVENT, i, 0, bytes(n)) for i, n in enumerate(sizes)]
    left, sent = list(waiting), []
    while left:
        batch = batch_of(left)
        assert len(batch) == 1 or len(pack(batch)) <= BATCH
        sent += batch
    assert sent == waiting


OUTCOMES = [
    Returned(Encoded('{"a":1,\n"b":[0.1,2]}')),
    Returned(Encoded('{"a":1}'), Encoded('{"brief":true}')),
    Crashed(-11),
    Crashed(None, "it said\nwhy"),
    TimedOut(0.25),
    TimedOut(0.25, grace=0.5),
    Silent(1.5),
    MemoryExceeded(3 * 2**30, 2**30),
    Terminated(),
]


@pytest.mark.parametrize("outcome", OUTCOMES, ids=repr)
def test_outcomes_cross_as_they_are(outcome):
    assert load_outcome(dump_outcome(outcome)) == outcome


@pytest.mark.parametrize("kind", [Raised, Terminated, lambda error: TimedOut(1.0, error)])
@pytest.mark.parametrize("error", [GoalUnreachable, Canceled, DeadlineExceeded])
def test_errors_in_outcomes_keep_their_class(kind, error):
    told = load_outcome(dump_outcome(kind(error("why", {"metres": 0.1}))))
    assert type(told.error) is error
    assert (told.error.detail, told.error.evidence) == ("why", {"metres": 0.1})


def test_only_the_dispatcher_says_that_a_host_is_lost():
    with pytest.raises(ValueError, match="no host tells of Lost"):
        dump_outcome(Lost("here", has_begun=True))
    with pytest.raises(ValueError, match="no end 'lost'"):
        load_outcome(b'{"end": "lost"}\n')


def test_an_error_that_the_host_does_not_know_is_what_it_was_to_the_dispatcher(monkeypatch):
    """Hosts load neither scenes nor plans, and pass on what their workers raise."""
    text = dump_error(StrangeToHosts("odd", {"n": 1}))
    with monkeypatch.context() as host:
        host.delitem(__import__("sys").modules, __name__)
        passed_on = load_error(text)
        assert isinstance(passed_on, RemoteFailure)
        text = dump_error(passed_on)
    assert type(load_error(text)) is StrangeToHosts


class StrangeToHosts(WayproofError):
    code = "strange_to_hosts"


def test_a_plan_crosses_as_it_is():
    terms = (Terms(), Terms(7, 2**30, 5.0, is_offline=True, logs=LogTerms("text", "debug")))
    plan = HostPlan(("a.b", "c"), "warm_up", terms, "0.1", "/data", HostTimeouts(lost=3.0))
    assert HostPlan.loaded(plan.dumped()) == plan
    with pytest.raises(TypeError):
        HostPlan.loaded(plan.dumped().replace(b'"niceness"', b'"nicer"'))
