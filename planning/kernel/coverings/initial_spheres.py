"""Initial spheres: few candidate balls that hold a shape's points and reach little beyond it."""

from collections.abc import Iterator
from itertools import product
from math import prod

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array, Indices
from planning.kernel.coverings.ball_choices import BallChoices

_HALVINGS = 10


def initial_spheres(
    choices: BallChoices, aim: float, most: int
) -> tuple[Float64[np.ndarray, "k 3"], float]:
    """Return the centres of balls that hold every point, and the reach that they need [m].

    Args:
        choices: Candidate balls.
        aim: If this reach suffices for `most` balls or fewer, the greedy cover is returned.
        most: Largest number of balls.
    """
    gaps = choices.gaps
    few = _greedy(gaps <= aim)
    if 0 < len(few) <= most:
        return choices.centers[few], aim
    begun = (_halving(gaps, most), *_lattices(choices, most))
    found = [_filled(gaps, chosen, most) for chosen in begun]
    reaches = [float(gaps[chosen].min(axis=0).max()) for chosen in found]
    best = int(np.argmin(reaches))
    return choices.centers[found[best]], reaches[best]


def _greedy(held: Bool[np.ndarray, "n m"]) -> Indices:
    """Return balls that hold every point; none if all of them do not.

    Greedy set cover: always the ball that holds most of the remaining points (Chvatal, "A greedy
    heuristic for the set-covering problem", 1979).
    """
    left = held.any(axis=0)
    gains = held.sum(axis=1)
    taken: list[int] = []
    if not left.all():
        return np.array(taken, dtype=np.int64)
    while left.any():
        taken.append(int(np.argmax(gains)))
        fresh = held[taken[-1]] & left
        left &= ~fresh
        gains -= held[:, fresh].sum(axis=1)
    return np.array(taken, dtype=np.int64)


def _halving(gaps: Array, most: int) -> Indices:
    """Return the greedy cover at the least reach, by bisection, with few enough balls."""
    farthest = gaps.max(axis=1)
    best = np.array([np.argmin(farthest)])
    low, high = float(gaps.min(axis=0).max()), float(farthest.min())
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        taken = _greedy(gaps <= middle)
        if 0 < len(taken) <= most:
            best, high = taken, middle
        else:
            low = middle
    return best


def _lattices(choices: BallChoices, most: int) -> Iterator[Indices]:
    """Yield the best ball for each cell of lattices; longer sides are divided more often."""
    low, high = choices.points.min(axis=0), choices.points.max(axis=0)
    place = (choices.points - low) / np.maximum(high - low, 1e-300)
    longest = np.argsort(low - high, kind="stable")
    for along in product(range(1, most + 1), repeat=3):
        if along[0] < along[1] or along[1] < along[2] or not most / 2 < prod(along) <= most:
            continue
        counts = np.array(along)[np.argsort(longest)]
        cell = np.minimum((place * counts).astype(int), counts - 1)
        number = (cell[:, 0] * counts[1] + cell[:, 1]) * counts[2] + cell[:, 2]
        order = np.argsort(number, kind="stable")
        starts = np.flatnonzero(np.diff(number[order], prepend=-1))
        farthest = np.maximum.reduceat(choices.gaps[:, order], starts, axis=1)
        yield np.unique(np.argmin(farthest, axis=0))


def _filled(gaps: Array, chosen: Indices, most: int) -> Indices:
    """Return the choice with more balls, each the one that lowers the farthest reaches most.

    Fourth powers approximate the farthest reach: in symmetric shapes no ball alone lowers that.
    """
    left = gaps[chosen].min(axis=0)
    more = list(chosen)
    while len(more) < most:
        lower = np.maximum(np.minimum(gaps, left), 0.0)
        more.append(int(np.argmin(((lower * lower) ** 2).sum(axis=1))))
        left = np.minimum(left, gaps[more[-1]])
    return np.unique(np.array(more))
