"""Smallest delays by a network of differences, against every combination on a grid."""

from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planning.pipeline.schedules.delay_network import smallest_delays
from tests.clocks import no_hurry

ENDS = st.integers(-4, 4)


@st.composite
def intervals(draw: st.DrawFn) -> list[tuple[float, float]]:
    """Draw disjoint intervals with integer ends, some of them without end."""
    ends = sorted(draw(st.sets(ENDS, max_size=6)))
    found = [(float(a), float(b)) for a, b in zip(ends[::2], ends[1::2], strict=False)]
    if draw(st.booleans()):
        found = [(-np.inf, float(ends[0]) - 1 if ends else 0.0), *found]
    if draw(st.booleans()):
        found = [*found, (float(ends[-1]) + 1 if ends else 0.0, np.inf)]
    return found


@st.composite
def problems(draw: st.DrawFn) -> tuple[int, dict[tuple[int, int], list[tuple[float, float]]]]:
    count = draw(st.integers(2, 4))
    pairs = [(i, j) for j in range(count) for i in range(j)]
    return count, {pair: draw(intervals()) for pair in pairs}


@given(problem=problems())
def test_they_are_the_first_of_all_in_lexicographic_order(
    problem: tuple[int, dict[tuple[int, int], list[tuple[float, float]]]],
) -> None:
    """Ends are integers, so the smallest delays are, and none is larger than all gaps together."""
    count, allowed = problem
    largest = 6 * (count - 1)
    grid = range(largest + 1)
    is_allowed = {
        pair: {r for r in range(-largest, largest + 1) if any(a <= r <= b for a, b in own)}
        for pair, own in allowed.items()
    }
    first = next(
        (
            delays
            for delays in product(grid, repeat=count)
            if all(delays[j] - delays[i] in own for (i, j), own in is_allowed.items())
        ),
        None,
    )
    found = smallest_delays(count, allowed, no_hurry())
    assert (None if found is None else found.delays) == first
    for k, other in enumerate(found.waits_for if found else ()):
        assert (other is not None) == (found is not None and found.delays[k] > 0)


def test_each_that_waits_knows_for_whom() -> None:
    after = [(1.0, np.inf)]
    found = smallest_delays(
        3, {(0, 1): after, (1, 2): after, (0, 2): [(-np.inf, np.inf)]}, no_hurry()
    )
    assert found is not None
    assert found.delays == (0.0, 1.0, 2.0)
    assert found.waits_for == (None, 0, 1)
