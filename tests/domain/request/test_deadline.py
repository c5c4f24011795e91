"""Deadlines: the earlier of two, what a cancel means to them, and what they cut."""

import pickle
from collections.abc import Callable

import pytest

from planning.domain.request.deadline import NO_DEADLINE, Deadline
from planning.errors import Canceled, DeadlineExceeded


class Clock:
    """A clock that is set by hand, and somebody who may cancel."""

    def __init__(self) -> None:
        self.now = 100.0
        self.is_canceled = False

    def deadline(self, seconds: float) -> Deadline:
        return Deadline.after(seconds, lambda: self.now, lambda: self.is_canceled)


def test_a_budget_within_a_deadline_never_exceeds_it() -> None:
    clock = Clock()
    whole = clock.deadline(2.0)
    assert whole.within(None) is whole
    assert whole.within(0.5).remaining == pytest.approx(0.5)
    assert whole.within(9.0).remaining == pytest.approx(2.0)
    assert whole.within(0.0).is_over
    clock.now += 1.8
    assert whole.within(0.5).remaining == pytest.approx(0.2)


def test_a_cancel_ends_a_hasty_deadline_without_an_outcry() -> None:
    clock = Clock()
    hasty = clock.deadline(2.0).expired_when_canceled
    assert hasty.remaining == pytest.approx(2.0)
    assert not hasty.at_fraction(0.5).is_over
    share = hasty.at_fraction(0.5)
    clock.is_canceled = True
    assert hasty.is_over
    assert share.is_over
    assert hasty.at_fraction(0.5).is_over
    assert hasty.remaining == 0.0
    with pytest.raises(DeadlineExceeded):
        hasty.check("refine")


def test_an_uncancelable_deadline_heeds_the_clock_alone() -> None:
    clock = Clock()
    deadline = clock.deadline(2.0)
    clock.is_canceled = True
    with pytest.raises(Canceled):
        deadline.check("certify")
    deadline.uncancelable.check("certify")
    clock.now += 3.0
    with pytest.raises(DeadlineExceeded):
        deadline.uncancelable.check("certify")


DERIVED: dict[str, Callable[[Deadline], Deadline]] = {
    "itself": lambda whole: whole,
    "share": lambda whole: whole.at_fraction(0.5),
    "within": lambda whole: whole.within(0.1),
    "limited": lambda whole: whole.limited(0.1),
    "uncancelable": lambda whole: whole.uncancelable,
    "hasty": lambda whole: whole.expired_when_canceled.at_fraction(0.1),
}


@pytest.mark.parametrize("name", DERIVED)
def test_whatever_is_made_of_a_deadline_tells_what_it_cuts(name: str) -> None:
    clock, cuts = Clock(), list[float]()
    deadline = DERIVED[name](clock.deadline(2.0).with_on_expiry(lambda: cuts.append(clock.now)))
    deadline.check("search")
    assert not deadline.is_over
    assert not cuts
    clock.now += 2.0
    assert deadline.is_over
    with pytest.raises(DeadlineExceeded):
        deadline.check("search")
    assert cuts == [102.0, 102.0]


def test_a_cancel_cuts_nothing() -> None:
    clock, cuts = Clock(), list[int]()
    deadline = clock.deadline(2.0).with_on_expiry(lambda: cuts.append(1))
    clock.is_canceled = True
    assert deadline.is_over
    with pytest.raises(Canceled):
        deadline.check("search")
    assert not cuts


def test_a_limit_is_what_is_allowed_if_it_ends_first() -> None:
    clock = Clock()
    assert clock.deadline(2.0).limited(3.0).time_limit == 2.0
    limited = clock.deadline(2.0).limited(0.5)
    clock.now += 0.5
    with pytest.raises(DeadlineExceeded, match=r"0\.5 s ran out during refine") as caught:
        limited.check("refine")
    assert caught.value.evidence == {"allowed": 0.5, "during": "refine"}


def test_who_has_no_hurry_is_never_late() -> None:
    NO_DEADLINE.check("retime")
    assert not NO_DEADLINE.at_fraction(0.5).is_over


def test_a_failure_keeps_its_stage_and_timings_in_other_words_and_other_processes() -> None:
    late = DeadlineExceeded("late", {"allowed": 1.0}).in_stage("certify")
    late.timings = {"certify": 1.0, "total": 2.0}
    for failure in (late.saying("too late", {"tried": 3}), pickle.loads(pickle.dumps(late))):
        assert isinstance(failure, DeadlineExceeded)
        assert (failure.stage, failure.timings) == ("certify", late.timings)
    assert late.saying("too late", {"tried": 3}).evidence == {"allowed": 1.0, "tried": 3}
