"""ArcSegments: the arcs and lines of one car path, as the variables of its optimisation.

A segment is a signed length (`ways`) [m], negative for backwards, and a curvature (`bends`) [1/m],
positive to the left, both of the car's origin. Whatever their values, the car does not slip, and
bounds on curvature bound the turning radius: the only equality constraint left is that the path
ends at the goal. The other joints of the group move in straight lines along each segment, so their
positions between segments determine them.

With t = bend * way a segment leads, in the complex plane and in the frame of its beginning, to

    way * f(t),  f(t) = (exp(i t) - 1) / (i t),  f'(t) = (exp(i t) - f(t)) / t,

and turns by t: the exponential of SE(2) (Lynch and Park, "Modern Robotics", 2017, section 3.2.3). A
change of a segment moves all that comes after it as a rigid body: by the displacement of the
segment's end and the rotation about it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from planning.domain.arrays import Array

# Angles below which divisions by the angle are replaced by series [rad].
_SMALL = 1e-4
_LEAST = 1e-12


@dataclass(frozen=True)
class ArcSegments:
    """Car path of n arc segments.

    Attributes:
        ways: Signed lengths of the segments [m], shape (n,).
        bends: Curvatures [1/m], shape (n,).
        others: Positions of the other joints before, between and after them, shape (n + 1, k).
    """

    ways: Float64[np.ndarray, " n"]
    bends: Float64[np.ndarray, " n"]
    others: Float64[np.ndarray, "m k"]

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.ways)

    @property
    def turns(self) -> Float64[np.ndarray, " n"]:
        """Turning angle of each segment [rad]."""
        return self.ways * self.bends

    @property
    def lengths(self) -> Float64[np.ndarray, " n"]:
        """Joint-space lengths of the segments (radians and metres weigh the same)."""
        return np.linalg.norm(np.column_stack([self.ways, self.turns, self.moves]), axis=1)

    def spots_at(self, s: Float64[np.ndarray, " m"]) -> "PathSamples":
        """Return samples at fractions of the total length."""
        ends = np.cumsum(self.lengths)
        owners = np.minimum(np.searchsorted(ends, s * ends[-1]), len(self) - 1)
        begun = s * ends[-1] - (ends - self.lengths)[owners]
        return PathSamples(
            owners, np.clip(begun / np.maximum(self.lengths[owners], _LEAST), 0.0, 1.0)
        )

    @property
    def moves(self) -> Float64[np.ndarray, "n k"]:
        """Displacements of the other joints along each segment."""
        return np.diff(self.others, axis=0)

    @property
    def variables(self) -> Float64[np.ndarray, " v"]:
        """Optimisation variables: all lengths and curvatures, and other joints between segments."""
        return np.concatenate([self.ways, self.bends, self.others[1:-1].ravel()])

    def with_variables(self, values: Float64[np.ndarray, " v"]) -> "ArcSegments":
        """Return segments with other variables, or with other lengths and curvatures alone."""
        n = len(self)
        others = self.others
        if len(values) > 2 * n:
            others = others.copy()
            others[1:-1] = values[2 * n :].reshape(others[1:-1].shape)
        return ArcSegments(values[:n], values[n : 2 * n], others)

    def without(self, i: int) -> "ArcSegments":
        """Return the segments without segment i, of two or more; its ends are joined."""
        others = np.delete(self.others, min(i + 1, len(self) - 1), axis=0)
        return ArcSegments(np.delete(self.ways, i), np.delete(self.bends, i), others)

    def with_one_of(self, i: int) -> "ArcSegments":
        """Return the path with segments i and i + 1 merged, of equal total length and turning."""
        ways, bends = np.delete(self.ways, i), np.delete(self.bends, i)
        ways[i] = self.ways[i] + self.ways[i + 1]
        bends[i] = self.turns[i : i + 2].sum() / ways[i]
        return ArcSegments(ways, bends, np.delete(self.others, i + 1, axis=0))


@dataclass(frozen=True)
class PathSamples:
    """Sample points of a car path.

    Attributes:
        owners: Index of the segment of each sample, shape (m,).
        fractions: Fraction of the segment before the sample, shape (m,).
    """

    owners: Int64[np.ndarray, " m"]
    fractions: Float64[np.ndarray, " m"]

    def and_then(self, more: "PathSamples") -> "PathSamples":
        """Return these samples followed by others."""
        owners = np.concatenate([self.owners, more.owners])
        return PathSamples(owners, np.concatenate([self.fractions, more.fractions]))


NOWHERE = PathSamples(np.zeros(0, dtype=np.int64), np.zeros(0))


@dataclass(frozen=True)
class SegmentPoses:
    """Poses of a car at samples of its path, and their derivatives.

    Attributes:
        poses: x, y, yaw, shape (m, 3).
        slopes: Derivatives with respect to lengths and curvatures, shape (m, 3, 2 n).
    """

    poses: Array
    slopes: Array


def knots_of(
    start: Float64[np.ndarray, "3"], letters: ArcSegments
) -> tuple[Any, Float64[np.ndarray, " m"]]:
    """Return x + i y and yaw before, between and after n segments, shapes (n + 1,)."""
    turns = letters.turns
    yaws = start[2] + np.concatenate([[0.0], np.cumsum(turns)])
    steps = letters.ways * _chords(turns) * np.exp(1j * yaws[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) + complex(start[0], start[1]), yaws


def end_of(start: Float64[np.ndarray, "3"], letters: ArcSegments) -> SegmentPoses:
    """Return the pose at the end of a path, as a single sample."""
    knots, yaws = knots_of(start, letters)
    shifts, turned = _all_before(letters, (knots, yaws), knots[-1:])
    pose = np.array([[knots[-1].real, knots[-1].imag, yaws[-1]]])
    slopes = np.stack([shifts.real, shifts.imag, turned[None]], axis=1)
    return SegmentPoses(pose, slopes.reshape(1, 3, 2 * len(letters)))


def places_on(
    start: Float64[np.ndarray, "3"], letters: ArcSegments, spots: PathSamples
) -> SegmentPoses:
    """Return the poses of the car at samples of a path."""
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
    """Return displacements and rotations of later points by each segment's variables, (m, 2, n)."""
    spots, yaws = knots
    ends = _slopes(letters.ways, letters.turns) * np.exp(1j * yaws[:-1])
    turned = np.stack([letters.bends, letters.ways])
    return ends + 1j * turned * (at[:, None] - spots[1:])[:, None], turned


def _chords(turns: Array) -> Any:
    """Return f, chord over length."""
    safe = np.where(turns == 0.0, 1.0, turns)
    return np.where(turns == 0.0, 1.0, np.expm1(1j * safe) / (1j * safe))


def _slopes(ways: Array, turns: Array) -> Any:
    """Return the derivatives of ends by length and by curvature, shape (2, m)."""
    ahead = np.exp(1j * turns)
    is_small = np.abs(turns) < _SMALL
    safe = np.where(is_small, 1.0, turns)
    bent = np.where(is_small, 0.5j - turns / 3, (ahead - _chords(turns)) / safe)
    return np.stack([ahead, ways * ways * bent])
