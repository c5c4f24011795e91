"""Stages within stages are counted once."""

from collections.abc import Callable

import pytest

from planning.domain.request.stopwatch import Stopwatch
from planning.errors import Canceled, DeadlineExceeded, NoPathFound, PlanningFailure


def clock_of(*times: float) -> Callable[[], float]:
    left = iter(times)
    return lambda: next(left)


def test_a_stage_within_another_counts_only_for_itself() -> None:
    # made, search begins, shortcut begins and ends, search ends, asked
    watch = Stopwatch(clock_of(0.0, 1.0, 3.0, 7.0, 9.0, 10.0))
    with watch.stage("search"), watch.stage("shortcut"):
        pass
    assert watch.seconds == {"shortcut": 4.0, "search": 4.0, "total": 10.0}


def test_stages_add_up_over_rounds() -> None:
    watch = Stopwatch(clock_of(0.0, *(float(t) for t in range(1, 13)), 13.0))
    for _ in range(3):
        with watch.stage("search"), watch.stage("shortcut"):
            pass
    assert watch.seconds == {"shortcut": 3.0, "search": 6.0, "total": 13.0}


@pytest.mark.parametrize("kind", [DeadlineExceeded, Canceled])
def test_what_ends_a_stage_is_told_the_outermost_one(kind: type[PlanningFailure]) -> None:
    watch = Stopwatch(clock_of(0.0, 1.0, 2.0, 4.0, 7.0, 8.0))
    with (
        pytest.raises(kind) as caught,
        watch.timing_failures(),
        watch.stage("goals"),
        watch.stage("line"),
    ):
        raise kind("late").in_stage("elsewhere")
    assert caught.value.stage == "goals"
    assert caught.value.timings == {"line": 2.0, "goals": 4.0, "total": 8.0}


def test_a_failure_that_knows_its_stage_keeps_it() -> None:
    watch = Stopwatch(lambda: 0.0)
    with pytest.raises(NoPathFound) as caught, watch.timing_failures(), watch.stage("retime"):
        raise NoPathFound("none")
    assert caught.value.stage == "search"
    assert set(caught.value.timings) == {"retime", "total"}


def test_stages_that_are_cut_are_told_once_in_order() -> None:
    watch = Stopwatch(lambda: 0.0)
    watch.record_cut()
    for stages in (("search", "shortcut"), ("refine",), ("search", "shortcut"), ("search",)):
        with watch.stage(stages[0]):
            if stages[1:]:
                with watch.stage(stages[1]):
                    watch.record_cut()
            else:
                watch.record_cut()
    assert watch.cut_short == ("shortcut", "refine", "search")


def test_finding_counts_and_using_what_is_found_does_not() -> None:
    # made, then a beginning and an end for each of two finds and for the end of them, asked
    watch = Stopwatch(clock_of(0.0, 1.0, 2.0, 5.0, 6.0, 8.0, 9.0, 9.0))
    assert list(watch.each("retime", iter("ab"))) == ["a", "b"]
    assert watch.seconds == {"retime": 3.0, "total": 9.0}


def test_stages_within_others_are_not_announced() -> None:
    stages: list[str] = []
    watch = Stopwatch(lambda: 0.0, stages.append)
    with watch.stage("search"), watch.stage("shortcut"):
        pass
    with watch.stage("refine"):
        pass
    assert stages == ["search", "refine"]
