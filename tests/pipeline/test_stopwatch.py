"""Stages within stages are counted once."""

from collections.abc import Callable

from planning.stopwatch import Stopwatch


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
