"""ArcSegments: the arcs and lines of one drive, as the numbers that are optimised.

A letter is a signed way [m], negative for backwards, and a bend [1/m], positive to the left, both
of the car's origin. Whatever they are, nothing slips, and nothing is tighter than the largest bend:
all that an optimiser must see to is that the drive ends where it should. The other joints of the
group go straight along each letter, so they are told by where they are between two letters.

With t = bend * way a letter leads, in the complex plane and as seen from its beginning, to

    way * f(t),  f(t) = (exp(i t) - 1) / (i t),  f'(t) = (exp(i t) - f(t)) / t,

and turns by t: the exponential of SE(2) (Lynch and Park, "Modern Robotics", 2017, section 3.2.3). A
change of it carries all that comes after along like a rigid body, shifted by what the letter's end
is shifted by and turned about it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Turns smaller than this have the series of what divides by them [rad].
_SMALL = 1e-4
_LEAST = 1e-12


@dataclass(frozen=True)
class ArcSegments:
    """One drive.

    Attributes:
        ways: Of n letters [m], shape (n,).
        bends: Of each [1/m], shape (n,).
        others: Positions of the other joints before, between and after them, shape (n + 1, k).
    """

    ways: Float64[np.ndarray, " n"]
    bends: Float64[np.ndarray, " n"]
    others: Float64[np.ndarray, "m k"]

    def __len__(self) -> int:
        """Return the number of letters."""
        return len(self.ways)

    @property
    def turns(self) -> Float64[np.ndarray, " n"]:
        """Of each letter [rad]."""
        return self.ways * self.bends

    @property
    def lengths(self) -> Float64[np.ndarray, " n"]:
        """Joint-space lengths of the letters (radians and metres weigh the same)."""
        return np.linalg.norm(np.column_stack([self.ways, self.turns, self.moves]), axis=1)

    def spots_at(self, s: Float64[np.ndarray, " m"]) -> "PathSamples":
        """Return the spots at shares of the whole length."""
        ends = np.cumsum(self.lengths)
        owners = np.minimum(np.searchsorted(ends, s * ends[-1]), len(self) - 1)
        begun = s * ends[-1] - (ends - self.lengths)[owners]
        return PathSamples(
            owners, np.clip(begun / np.maximum(self.lengths[owners], _LEAST), 0.0, 1.0)
        )

    @property
    def moves(self) -> Float64[np.ndarray, "n k"]:
        """Of the other joints along each letter."""
        return np.diff(self.others, axis=0)

    @property
    def variables(self) -> Float64[np.ndarray, " v"]:
        """All ways, all bends, and where the other joints are between letters."""
        return np.concatenate([self.ways, self.bends, self.others[1:-1].ravel()])

    def with_variables(self, values: Float64[np.ndarray, " v"]) -> "ArcSegments":
        """Return letters with other variables, or of the ways and bends alone."""
        n = len(self)
        others = self.others
        if len(values) > 2 * n:
            others = others.copy()
            others[1:-1] = values[2 * n :].reshape(others[1:-1].shape)
        return ArcSegments(values[:n], values[n : 2 * n], others)

    def without(self, i: int) -> "ArcSegments":
        """Return what is left of two letters or more without letter i, one end put to the other."""
        others = np.delete(self.others, min(i + 1, len(self) - 1), axis=0)
        return ArcSegments(np.delete(self.ways, i), np.delete(self.bends, i), others)

    def with_one_of(self, i: int) -> "ArcSegments":
        """Return the drive with one letter for letters i and i + 1, as long and turning as far."""
        ways, bends = np.delete(self.ways, i), np.delete(self.bends, i)
        ways[i] = self.ways[i] + self.ways[i + 1]
        bends[i] = self.turns[i : i + 2].sum() / ways[i]
        return ArcSegments(ways, bends, np.delete(self.others, i + 1, axis=0))


@dataclass(frozen=True)
class PathSamples:
    """Places on a drive.

    Attributes:
        owners: On which letter each is, shape (m,).
        fractions: How far along it, shape (m,).
    """

    owners: Int64[np.ndarray, " m"]
    fractions: Float64[np.ndarray, " m"]

    def and_then(self, more: "PathSamples") -> "PathSamples":
        """Return these and others."""
        owners = np.concatenate([self.owners, more.owners])
        return PathSamples(owners, np.concatenate([self.fractions, more.fractions]))


NOWHERE = PathSamples(np.zeros(0, dtype=np.int64), np.zeros(0))


@dataclass(frozen=True)
class SegmentPoses:
    """Where a car is at some places of a drive, and how that changes with ways and bends.

    Attributes:
        poses: x, y, yaw, shape (m, 3).
        slopes: Their derivatives, shape (m, 3, 2 n).
    """

    poses: Array
    slopes: Array


def knots_of(
    start: Float64[np.ndarray, "3"], letters: ArcSegments
) -> tuple[Any, Float64[np.ndarray, " m"]]:
    """Return x + i y and yaw before, between and after n letters, shapes (n + 1,)."""
    turns = letters.turns
    yaws = start[2] + np.concatenate([[0.0], np.cumsum(turns)])
    steps = letters.ways * _chords(turns) * np.exp(1j * yaws[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) + complex(start[0], start[1]), yaws


def end_of(start: Float64[np.ndarray, "3"], letters: ArcSegments) -> SegmentPoses:
    """Return where a drive ends, as the only place."""
    knots, yaws = knots_of(start, letters)
    shifts, turned = _all_before(letters, (knots, yaws), knots[-1:])
    pose = np.array([[knots[-1].real, knots[-1].imag, yaws[-1]]])
    slopes = np.stack([shifts.real, shifts.imag, turned[None]], axis=1)
    return SegmentPoses(pose, slopes.reshape(1, 3, 2 * len(letters)))


def places_on(
    start: Float64[np.ndarray, "3"], letters: ArcSegments, spots: PathSamples
) -> SegmentPoses:
    """Return where the car is at spots of a drive."""
    owners, fractions = spots.owners, spots.fractions
    knots, yaws = knots_of(start, letters)
    ways, turns = fractions * letters.ways[owners], fractions * letters.turns[owners]
    headings = np.exp(1j * yaws[owners])
    at = knots[owners] + ways * _chords(turns) * headings
    shifts, turned = _all_before(letters, (knots, yaws), at)
    is_past = (np.arange(len(letters)) < owners[:, None])[:, None]
    shifts, turned = shifts * is_past, turned * is_past
    rows, own = np.arange(len(owners)), _slopes(ways, turns) * headings
    shifts[rows, 0, owners], shifts[rows, 1, owners] = own[0] * fractions, own[1]
    turned[rows, 0, owners] = letters.bends[owners] * fractions
    turned[rows, 1, owners] = ways
    slopes = np.stack([shifts.real, shifts.imag, turned], axis=1)
    poses = np.stack([at.real, at.imag, yaws[owners] + turns], axis=1)
    return SegmentPoses(poses, slopes.reshape(len(owners), 3, 2 * len(letters)))


def _all_before(letters: ArcSegments, knots: tuple[Any, Array], at: Any) -> tuple[Any, Array]:
    """Return by what places after all letters are shifted and turned with each, (m, 2, n)."""
    spots, yaws = knots
    ends = _slopes(letters.ways, letters.turns) * np.exp(1j * yaws[:-1])
    turned = np.stack([letters.bends, letters.ways])
    return ends + 1j * turned * (at[:, None] - spots[1:])[:, None], turned


def _chords(turns: Array) -> Any:
    """Return f."""
    safe = np.where(turns == 0.0, 1.0, turns)
    return np.where(turns == 0.0, 1.0, np.expm1(1j * safe) / (1j * safe))


def _slopes(ways: Array, turns: Array) -> Any:
    """Return what ends are shifted by with the way and with the bend, shape (2, m)."""
    ahead = np.exp(1j * turns)
    is_small = np.abs(turns) < _SMALL
    safe = np.where(is_small, 1.0, turns)
    bent = np.where(is_small, 0.5j - turns / 3, (ahead - _chords(turns)) / safe)
    return np.stack([ahead, ways * ways * bent])
