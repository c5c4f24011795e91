"""cheapest_first(): candidates in the order in which they are certified, timed when needed."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from itertools import chain

from planning.errors import DeadlineExceeded
from planning.pipeline.timing.candidate_timing import REFINED_CURVE, CandidateMotion
from planning.pipeline.timing.path_curves import PathCurve

# Times a curve along the path, in less time if that is for comparison only.
type TimeCurve = Callable[[PathCurve, bool], list[CandidateMotion]]


def cheapest_first(
    timed: list[CandidateMotion],
    curves: Iterable[PathCurve],
    time_curve: TimeCurve,
    *,
    slower: Sequence[PathCurve] = (),
    compares: bool = True,
) -> Generator[CandidateMotion, None, list[CandidateMotion] | None]:
    """Yield candidates, of those that are timed the cheapest first; each yield is after a refusal.

    Curves along the path are timed one by one. Where all that are timed were refused, the next one
    is timed before the refined curve is yielded: what is delivered is no worse than the motion that
    the unrefined path would have had.

    Args:
        timed: Candidates that are timed already.
        curves: Further curves along the path.
        time_curve: Returns the candidates of a curve, none if it cannot be timed.
        slower: Curves that cost more than the cheapest of `timed`, whatever their time: they are
            timed once that is refused, and then compared as if they had been timed.
        compares: Whether there is time for that while the refined curve waits.

    Returns:
        Candidates of the last further curve; None if there was none.

    Raises:
        DeadlineExceeded: Time ran out, and no candidate is left.
        Canceled: Cancellation was requested.
    """
    waiting = sorted(timed, key=lambda candidate: candidate.cost)
    rest = iter(curves)
    if slower:
        yield waiting.pop(0)
        waiting, untimed = _with_slower(waiting, slower, time_curve)
        compares, rest = compares and not untimed, chain(untimed, rest)
    return (yield from _one_by_one(waiting, rest, time_curve, compares))


def _one_by_one(
    waiting: list[CandidateMotion],
    rest: Iterator[PathCurve],
    time_curve: TimeCurve,
    compares: bool,  # noqa: FBT001  (as of `cheapest_first`)
) -> Generator[CandidateMotion, None, list[CandidateMotion] | None]:
    """Yield what waits, cheapest first, and further curves when their turn comes."""
    last = None
    while True:
        if all(c.name == REFINED_CURVE for c in waiting) and (compares or not waiting):
            curve = next(rest, None)
            if curve is not None:
                try:
                    last = time_curve(curve, bool(waiting))
                except DeadlineExceeded:
                    # The remaining time is for certifying the motion that is timed already.
                    if not waiting:
                        raise
                    compares, rest = False, chain([curve], rest)
                else:
                    waiting = sorted([*waiting, *last], key=lambda candidate: candidate.cost)
                    continue
            elif not waiting:
                return last
        yield waiting.pop(0)


def _with_slower(
    waiting: list[CandidateMotion], slower: Sequence[PathCurve], time_curve: TimeCurve
) -> tuple[list[CandidateMotion], Sequence[PathCurve]]:
    """Return all that wait, the cheapest first, and the curves for whose timing no time was left.

    Raises:
        DeadlineExceeded: Time ran out, and no candidate is left.
    """
    untimed: Sequence[PathCurve] = ()
    for place, curve in enumerate(slower):
        try:
            waiting = [*waiting, *time_curve(curve, bool(waiting))]
        except DeadlineExceeded:
            if not waiting:
                raise
            untimed = slower[place:]
            break
    return sorted(waiting, key=lambda candidate: candidate.cost), untimed
