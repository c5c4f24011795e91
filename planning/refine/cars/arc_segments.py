"""ArcSegments: the arcs and lines of one car path, as the variables of its optimization.

A segment is a signed length (`signed_lengths`) [m], negative for backwards, and a curvature
(`curvatures`) [1/m], positive to the left, both of the car's origin. Whatever their values, the car
does not slip, and bounds on curvature bound the turning radius: the only equality constraint left
is that the path ends at the goal. The other joints of the group move in straight lines along each
segment, so their positions between segments determine them.

With t = curvature * length a segment leads, in the complex plane and in its first frame, to

    length * f(t),  f(t) = (exp(i t) - 1) / (i t),  f'(t) = (exp(i t) - f(t)) / t,

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
_SMALL_ANGLE = 1e-4
_MIN_LENGTH = 1e-12


@dataclass(frozen=True)
class ArcSegments:
    """Car path of n arc segments.

    Attributes:
        signed_lengths: Signed lengths of the segments [m], shape (n,).
        curvatures: Curvatures [1/m], shape (n,).
        other_positions: Positions of the other joints before, between and after them, shape (n + 1,
            k).
    """

    signed_lengths: Float64[np.ndarray, " n"]
    curvatures: Float64[np.ndarray, " n"]
    other_positions: Float64[np.ndarray, "m k"]

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.signed_lengths)

    @property
    def turning_angles(self) -> Float64[np.ndarray, " n"]:
        """Turning angle of each segment [rad]."""
        return self.signed_lengths * self.curvatures

    @property
    def lengths(self) -> Float64[np.ndarray, " n"]:
        """Joint-space lengths of the segments (radians and metres weigh the same)."""
        return np.linalg.norm(
            np.column_stack([self.signed_lengths, self.turning_angles, self.other_displacements]),
            axis=1,
        )

    def samples_at(self, s: Float64[np.ndarray, " m"]) -> "PathSamples":
        """Return samples at fractions of the total length."""
        end_lengths = np.cumsum(self.lengths)
        segments = np.minimum(np.searchsorted(end_lengths, s * end_lengths[-1]), len(self) - 1)
        lengths_before = s * end_lengths[-1] - (end_lengths - self.lengths)[segments]
        return PathSamples(
            segments,
            np.clip(lengths_before / np.maximum(self.lengths[segments], _MIN_LENGTH), 0.0, 1.0),
        )

    @property
    def other_displacements(self) -> Float64[np.ndarray, "n k"]:
        """Displacements of the other joints along each segment."""
        return np.diff(self.other_positions, axis=0)

    @property
    def variables(self) -> Float64[np.ndarray, " v"]:
        """Optimization variables: all lengths and curvatures, and other joints between segments."""
        return np.concatenate([
            self.signed_lengths,
            self.curvatures,
            self.other_positions[1:-1].ravel(),
        ])

    def with_variables(self, values: Float64[np.ndarray, " v"]) -> "ArcSegments":
        """Return segments with other variables, or with other lengths and curvatures alone."""
        n = len(self)
        other_positions = self.other_positions
        if len(values) > 2 * n:
            other_positions = other_positions.copy()
            other_positions[1:-1] = values[2 * n :].reshape(other_positions[1:-1].shape)
        return ArcSegments(values[:n], values[n : 2 * n], other_positions)

    def without(self, i: int) -> "ArcSegments":
        """Return the segments without segment i, of two or more; its ends are joined."""
        other_positions = np.delete(self.other_positions, min(i + 1, len(self) - 1), axis=0)
        return ArcSegments(
            np.delete(self.signed_lengths, i), np.delete(self.curvatures, i), other_positions
        )

    def merged(self, i: int) -> "ArcSegments":
        """Return the path with segments i and i + 1 merged, of equal total length and turning."""
        signed_lengths = np.delete(self.signed_lengths, i)
        curvatures = np.delete(self.curvatures, i)
        signed_lengths[i] = self.signed_lengths[i] + self.signed_lengths[i + 1]
        curvatures[i] = self.turning_angles[i : i + 2].sum() / signed_lengths[i]
        return ArcSegments(
            signed_lengths, curvatures, np.delete(self.other_positions, i + 1, axis=0)
        )


@dataclass(frozen=True)
class PathSamples:
    """Sample points of a car path.

    Attributes:
        segments: Index of the segment of each sample, shape (m,).
        fractions: Fraction of the segment before the sample, shape (m,).
    """

    segments: Int64[np.ndarray, " m"]
    fractions: Float64[np.ndarray, " m"]

    def followed_by(self, more: "PathSamples") -> "PathSamples":
        """Return these samples followed by others."""
        segments = np.concatenate([self.segments, more.segments])
        return PathSamples(segments, np.concatenate([self.fractions, more.fractions]))


NO_SAMPLES = PathSamples(np.zeros(0, dtype=np.int64), np.zeros(0))


@dataclass(frozen=True)
class SegmentPoses:
    """Poses of a car at samples of its path, and their derivatives.

    Attributes:
        poses: x, y, yaw, shape (m, 3).
        jacobians: Derivatives with respect to lengths and curvatures, shape (m, 3, 2 n).
    """

    poses: Array
    jacobians: Array


def knot_poses(
    start: Float64[np.ndarray, "3"], segments: ArcSegments
) -> tuple[Any, Float64[np.ndarray, " m"]]:
    """Return x + i y and yaw before, between and after n segments, shapes (n + 1,)."""
    turning_angles = segments.turning_angles
    yaws = start[2] + np.concatenate([[0.0], np.cumsum(turning_angles)])
    steps = segments.signed_lengths * _chord_ratios(turning_angles) * np.exp(1j * yaws[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) + complex(start[0], start[1]), yaws


def end_pose(start: Float64[np.ndarray, "3"], segments: ArcSegments) -> SegmentPoses:
    """Return the pose at the end of a path, as a single sample."""
    knots, yaws = knot_poses(start, segments)
    displacements, rotations = _later_point_derivatives(segments, (knots, yaws), knots[-1:])
    pose = np.array([[knots[-1].real, knots[-1].imag, yaws[-1]]])
    jacobians = np.stack([displacements.real, displacements.imag, rotations[None]], axis=1)
    return SegmentPoses(pose, jacobians.reshape(1, 3, 2 * len(segments)))


def sample_poses(
    start: Float64[np.ndarray, "3"], segments: ArcSegments, samples: PathSamples
) -> SegmentPoses:
    """Return the poses of the car at samples of a path."""
    owning_segments, fractions = samples.segments, samples.fractions
    knots, yaws = knot_poses(start, segments)
    signed_lengths = fractions * segments.signed_lengths[owning_segments]
    turning_angles = fractions * segments.turning_angles[owning_segments]
    headings = np.exp(1j * yaws[owning_segments])
    points = knots[owning_segments] + signed_lengths * _chord_ratios(turning_angles) * headings
    displacements, rotations = _later_point_derivatives(segments, (knots, yaws), points)
    is_past = (np.arange(len(segments)) < owning_segments[:, None])[:, None]
    displacements, rotations = displacements * is_past, rotations * is_past
    rows = np.arange(len(owning_segments))
    by_length, by_curvature = _end_derivatives(signed_lengths, turning_angles) * headings
    displacements[rows, 0, owning_segments] = by_length * fractions
    displacements[rows, 1, owning_segments] = by_curvature
    rotations[rows, 0, owning_segments] = segments.curvatures[owning_segments] * fractions
    rotations[rows, 1, owning_segments] = signed_lengths
    jacobians = np.stack([displacements.real, displacements.imag, rotations], axis=1)
    poses = np.stack([points.real, points.imag, yaws[owning_segments] + turning_angles], axis=1)
    return SegmentPoses(poses, jacobians.reshape(len(owning_segments), 3, 2 * len(segments)))


def _later_point_derivatives(
    segments: ArcSegments, knots: tuple[Any, Array], points: Any
) -> tuple[Any, Array]:
    """Return displacements and rotations of later points by each segment's variables, (m, 2, n)."""
    knot_points, yaws = knots
    headings = np.exp(1j * yaws[:-1])
    by_end = _end_derivatives(segments.signed_lengths, segments.turning_angles) * headings
    rotations = np.stack([segments.curvatures, segments.signed_lengths])
    levers = (points[:, None] - knot_points[1:])[:, None]
    return by_end + 1j * rotations * levers, rotations


def _chord_ratios(turning_angles: Array) -> Any:
    """Return f, chord over length."""
    divisors = np.where(turning_angles == 0.0, 1.0, turning_angles)
    return np.where(turning_angles == 0.0, 1.0, np.expm1(1j * divisors) / (1j * divisors))


def _end_derivatives(signed_lengths: Array, turning_angles: Array) -> Any:
    """Return the derivatives of ends by length and by curvature, shape (2, m)."""
    headings = np.exp(1j * turning_angles)
    is_small = np.abs(turning_angles) < _SMALL_ANGLE
    divisors = np.where(is_small, 1.0, turning_angles)
    by_curvature = np.where(
        is_small, 0.5j - turning_angles / 3, (headings - _chord_ratios(turning_angles)) / divisors
    )
    return np.stack([headings, signed_lengths * signed_lengths * by_curvature])
