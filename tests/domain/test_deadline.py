"""Deadlines: the earlier of two, and what a cancel means to them."""

import pytest

from planning.domain.deadline import Deadline
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
    hasty = clock.deadline(2.0).over_when_canceled
    assert hasty.remaining == pytest.approx(2.0)
    assert not hasty.share(0.5).is_over
    share = hasty.share(0.5)
    clock.is_canceled = True
    assert hasty.is_over
    assert share.is_over
    assert hasty.share(0.5).is_over
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
