"""cheapest_first(): candidates in the order in which they are certified, timed when needed."""

from collections.abc import Callable, Generator, Iterable
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
        compares: Whether there is time for that while the refined curve waits.

    Returns:
        Candidates of the last curve; None if there was no further curve.

    Raises:
        DeadlineExceeded: Time ran out, and no candidate is left.
        Canceled: Cancellation was requested.
    """
    waiting = sorted(timed, key=lambda candidate: candidate.cost)
    last, rest = None, iter(curves)
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
