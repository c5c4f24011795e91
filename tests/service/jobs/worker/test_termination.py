"""When a run is told to end and made to: on a loop whose clock the test moves."""

import asyncio

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from planning.errors import Canceled, DeadlineExceeded, GoalUnreachable, TrackingLost
from service.jobs.outcome import Crashed, Raised, Silent, Terminated, TimedOut, error_of, with_stage
from service.jobs.worker.termination import DEADLINE_GRACE, Termination

CRASH, REFUSAL = Crashed(-9), Raised(Canceled("noticed"))


class Loop(asyncio.SelectorEventLoop):
    """An event loop at a time of our choice."""

    now = 0.0

    def time(self):
        return self.now


async def passing(seconds):
    """Let time pass, and what is due happen."""
    asyncio.get_running_loop().now += seconds
    for _ in range(3):
        await asyncio.sleep(0)


def on_a_loop(story):
    with asyncio.Runner(loop_factory=Loop) as runner:
        return runner.run(story())


class Told:
    """A run that notes what happens to it, in order."""

    def __init__(self, allowed):
        self.notes = []
        self.stop = Termination(allowed)
        self.stop.begin(lambda: self.notes.append("told"), lambda: self.notes.append("forced"))


def test_a_run_that_is_late_is_told_and_then_made_to_end():
    async def story():
        run = Told(1.0)
        for seconds, notes in ((0.9, []), (0.2, ["told"]), (DEADLINE_GRACE, ["told", "forced"])):
            await passing(seconds)
            assert run.notes == notes
        assert run.stop.classify(CRASH) == run.stop.classify(REFUSAL) == TimedOut(1.0)

    on_a_loop(story)


def test_what_is_granted_beyond_the_allowed_time_is_told_apart_from_it():
    async def story():
        run = Told(9.0)
        run.stop.set_deadline(1.0, 0.5)
        for seconds, notes in ((1.4, []), (0.2, ["told"]), (DEADLINE_GRACE, ["told", "forced"])):
            await passing(seconds)
            assert run.notes == notes
        error = error_of(run.stop.classify(CRASH), 1)
        assert error.evidence == {"allowed": 1.0, "during": "worker", "grace": 0.5}
        assert "within the allowed 1 s, nor 0.5 s later" in error.detail

    on_a_loop(story)


@pytest.mark.parametrize("kind", [Canceled, DeadlineExceeded])
def test_a_run_that_ends_when_it_is_told_to_says_where_it_was(kind):
    async def story():
        run = Told(1.0)
        await passing(1.1)
        said = kind("noticed", {"during": "retime"}).in_stage("retime")
        said.timings = {"goals": 0.5, "retime": 0.6}
        error = error_of(run.stop.classify(Raised(said)), 1)
        assert isinstance(error, DeadlineExceeded)
        assert (error.stage, error.timings) == ("retime", said.timings)
        assert error.evidence["during"] == "retime"

    on_a_loop(story)


BEFORE = {"stage": "certify", "timings": {"load": 0.5, "certify": 1.0}}


@pytest.mark.parametrize("outcome", [TimedOut(2.0), CRASH, Silent(2.0)])
def test_a_run_that_is_ended_by_force_was_in_the_stage_that_it_told_last(outcome):
    error = with_stage(error_of(outcome, 1), BEFORE, 4.0)
    assert type(error) is type(error_of(outcome, 1))
    assert (error.stage, error.evidence["during"]) == ("certify", "certify")
    assert error.timings == {"load": 0.5, "certify": 3.5, "total": 4.0}
    assert "certify" in error.detail


@pytest.mark.parametrize("told", [{}, {"stage": None}, {"stage": "hang", "timings": None}])
def test_a_run_that_told_little_is_placed_as_far_as_that_goes(told):
    error = with_stage(error_of(TimedOut(2.0), 1), told, 3.0)
    is_known = bool(told.get("stage"))
    assert error.stage == ("hang" if is_known else "worker")
    assert error.timings == ({"hang": 3.0, "total": 3.0} if is_known else {})


def test_an_error_that_knows_its_stage_keeps_it():
    error = GoalUnreachable("too far")
    assert with_stage(error, BEFORE, 4.0) is error


@example(1.0, [(0.5, 5.0)])
@example(5.0, [(0.5, 1.0)])
@example(1.0, [(1.5, 5.0)])
@given(
    st.floats(0.1, 5.0),
    st.lists(st.tuples(st.floats(0.0, 2.0), st.floats(0.1, 5.0)), max_size=5),
)
def test_what_was_allowed_last_counts_unless_it_came_too_late(first, terms):
    async def story():
        run = Told(first)
        allowed, left = first, first
        for passed, seconds in terms:
            await passing(passed)
            left -= passed
            run.stop.set_deadline(seconds)
            if left > 0:
                allowed = left = seconds
        if left > 0:
            await passing(0.99 * left)
            assert run.notes == []
            await passing(0.02 * left)
        assert run.notes[0] == "told"
        assert run.stop.classify(CRASH) == TimedOut(allowed)

    on_a_loop(story)


@pytest.mark.parametrize(("outcome", "error"), [(CRASH, None), (REFUSAL, REFUSAL.error)])
def test_a_cancel_is_told_at_once_and_no_deadline_counts_after_it(outcome, error):
    async def story():
        run = Told(1.0)
        run.stop.cancel(0.5)
        run.stop.cancel(0.1)
        run.stop.set_deadline(9.0)
        assert run.notes == ["told"]
        await passing(0.4)
        assert run.notes == ["told"]
        await passing(0.2)
        assert run.notes == ["told", "forced"]
        await passing(5.0)
        assert run.stop.classify(outcome) == Terminated(error)

    on_a_loop(story)


@given(st.floats(0.1, 5.0), st.floats(0.0, 0.99), st.floats(0.3, 20.0))
def test_a_deadline_takes_nothing_of_the_grace_of_a_cancel(allowed, share, grace):
    async def story():
        run = Told(allowed)
        await passing(share * allowed)
        run.stop.cancel(grace)
        for _ in range(9):  # the deadline, and what follows it, would come in between
            await passing(0.11 * grace)
            assert run.notes == ["told"]
        await passing(0.02 * grace)
        assert run.notes == ["told", "forced"]
        assert run.stop.classify(CRASH) == Terminated()

    on_a_loop(story)


@given(st.floats(0.1, 5.0), st.lists(st.floats(0.05, 0.95), max_size=20), st.booleans())
def test_silence_is_noticed_and_words_are_not_silence(silence, pauses, is_canceled):
    async def story():
        run = Told(None)
        run.stop.limit_silence(silence)
        if is_canceled:
            run.stop.cancel(1e6)
        for pause in pauses:
            for _ in range(8):
                await passing(pause * silence / 8)
            run.stop.heard()
            assert "forced" not in run.notes
        for _ in range(30):
            await passing(0.05 * silence)
        assert run.notes[-1] == "forced"
        assert run.stop.classify(CRASH) == Silent(silence)

    on_a_loop(story)


def test_a_loop_that_stood_still_takes_nobody_for_silent():
    async def story():
        run = Told(None)
        run.stop.limit_silence(1.0)
        await passing(100.0)
        assert run.notes == []
        run.stop.heard()
        await passing(0.9)
        assert run.notes == []

    on_a_loop(story)


def test_a_robot_that_dies_on_its_way_to_rest_has_not_been_canceled():
    async def story():
        run = Told(None)
        run.stop.limit_silence(1.0)
        run.stop.cancel(0.5)
        assert run.stop.classify(CRASH) is CRASH
        lost = Raised(TrackingLost("0.2 rad away"))
        assert error_of(run.stop.classify(lost), 1) is lost.error

    on_a_loop(story)


def test_what_has_ended_is_told_nothing_and_ends_as_it_did():
    async def story():
        run = Told(1.0)
        run.stop.disarm()
        run.stop.set_deadline(0.1)
        await passing(5.0)
        assert run.notes == []
        assert run.stop.classify(CRASH) is CRASH

    on_a_loop(story)
