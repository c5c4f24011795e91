"""Initial spheres: few candidate balls that hold a shape's points and reach little beyond it."""

from collections.abc import Iterator
from itertools import product
from math import prod

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array, Indices
from planning.kernel.coverings.ball_choices import BallChoices

_NUM_BISECTIONS = 10


def initial_spheres(
    choices: BallChoices, target_reach: float, max_num_balls: int
) -> tuple[Float64[np.ndarray, "k 3"], float]:
    """Return the centres of balls that hold every point, and the reach that they need [m].

    Args:
        choices: Candidate balls.
        target_reach: If this reach suffices for `max_num_balls` balls or fewer, the greedy cover is
            returned.
        max_num_balls: Largest number of balls.
    """
    gaps = choices.gaps
    greedy_cover = _greedy_cover(gaps <= target_reach)
    if 0 < len(greedy_cover) <= max_num_balls:
        return choices.centers[greedy_cover], target_reach
    initial_covers = (
        _bisected_cover(gaps, max_num_balls),
        *_lattice_covers(choices, max_num_balls),
    )
    covers = [_with_more_balls(gaps, chosen, max_num_balls) for chosen in initial_covers]
    reaches = [float(gaps[chosen].min(axis=0).max()) for chosen in covers]
    best = int(np.argmin(reaches))
    return choices.centers[covers[best]], reaches[best]


def _greedy_cover(contains: Bool[np.ndarray, "n m"]) -> Indices:
    """Return balls that hold every point; none if all of them do not.

    Greedy set cover: always the ball that holds most of the remaining points (Chvatal, "A greedy
    heuristic for the set-covering problem", 1979).
    """
    uncovered = contains.any(axis=0)
    gains = contains.sum(axis=1)
    chosen: list[int] = []
    if not uncovered.all():
        return np.array(chosen, dtype=np.int64)
    while uncovered.any():
        chosen.append(int(np.argmax(gains)))
        newly_covered = contains[chosen[-1]] & uncovered
        uncovered &= ~newly_covered
        gains -= contains[:, newly_covered].sum(axis=1)
    return np.array(chosen, dtype=np.int64)


def _bisected_cover(gaps: Array, max_num_balls: int) -> Indices:
    """Return the greedy cover at the least reach, by bisection, with few enough balls."""
    farthest = gaps.max(axis=1)
    best = np.array([np.argmin(farthest)])
    low, high = float(gaps.min(axis=0).max()), float(farthest.min())
    for _ in range(_NUM_BISECTIONS):
        middle = (low + high) / 2
        cover = _greedy_cover(gaps <= middle)
        if 0 < len(cover) <= max_num_balls:
            best, high = cover, middle
        else:
            low = middle
    return best


def _lattice_covers(choices: BallChoices, max_num_balls: int) -> Iterator[Indices]:
    """Yield the best ball for each cell of lattices; longer sides are divided more often."""
    low, high = choices.points.min(axis=0), choices.points.max(axis=0)
    normalized_points = (choices.points - low) / np.maximum(high - low, 1e-300)
    longest = np.argsort(low - high, kind="stable")
    for divisions in product(range(1, max_num_balls + 1), repeat=3):
        if (
            divisions[0] < divisions[1]
            or divisions[1] < divisions[2]
            or not max_num_balls / 2 < prod(divisions) <= max_num_balls
        ):
            continue
        counts = np.array(divisions)[np.argsort(longest)]
        cell = np.minimum((normalized_points * counts).astype(int), counts - 1)
        number = (cell[:, 0] * counts[1] + cell[:, 1]) * counts[2] + cell[:, 2]
        order = np.argsort(number, kind="stable")
        starts = np.flatnonzero(np.diff(number[order], prepend=-1))
        farthest = np.maximum.reduceat(choices.gaps[:, order], starts, axis=1)
        yield np.unique(np.argmin(farthest, axis=0))


def _with_more_balls(gaps: Array, chosen: Indices, max_num_balls: int) -> Indices:
    """Return the choice with more balls, each the one that lowers the farthest reaches most.

    Fourth powers approximate the farthest reach: in symmetric shapes no ball alone lowers that.
    """
    min_gaps = gaps[chosen].min(axis=0)
    indices = list(chosen)
    while len(indices) < max_num_balls:
        lowered = np.maximum(np.minimum(gaps, min_gaps), 0.0)
        indices.append(int(np.argmin(((lowered * lowered) ** 2).sum(axis=1))))
        min_gaps = np.minimum(min_gaps, gaps[indices[-1]])
    return np.unique(np.array(indices))
