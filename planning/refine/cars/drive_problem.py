"""DriveProblem: a car's path to refine, and the conversion between paths and arc segments."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.steering import Steering, manifold_of, steering_of
from planning.refine.cars.arc_segments import ArcSegments, knot_poses

# Largest turning angle of one edge of a path, well below half a turn [rad].
_MAX_TURNING_ANGLE = 2.0
# Difference in curvature, or in motion of other joints per metre, below which segments are merged.
_MERGE_TOLERANCE = 1e-6
# Length below which the car stands still [m].
_MIN_LENGTH = 1e-9


@dataclass(frozen=True)
class DriveProblem:
    """Path of a group with one car, with its steering.

    Attributes:
        path: The path to refine; none of its joints floats.
        steering: Turning radius and directions of the car.
        car_index: Index of the car's first coordinate in q, and in v.
        other_indices: Indices of the other joints' coordinates.
        waypoints: The path's waypoints without jumps by full turns, shape (n, nq).
    """

    path: JointPath
    steering: Steering
    car_index: int
    other_indices: list[int]
    waypoints: Float64[np.ndarray, "n nq"]

    @classmethod
    def of(cls, path: JointPath) -> "DriveProblem":
        """Return the problem of a path of a group with one car and no floating joint."""
        ((name, steering),) = steering_of(path.group).items()
        car_index = path.group.velocity_names.index(f"{name}.x")
        other_indices = [
            i for i in range(path.group.num_positions) if not car_index <= i < car_index + 3
        ]
        return cls(path, steering, car_index, other_indices, path.continuous.waypoints)

    @property
    def start(self) -> Float64[np.ndarray, "3"]:
        """The car's x, y and yaw at the start."""
        return self.waypoints[0, self.car_index : self.car_index + 3]

    @property
    def goal(self) -> Float64[np.ndarray, "3"]:
        """The car's x, y and yaw at the goal."""
        return self.waypoints[-1, self.car_index : self.car_index + 3]

    @property
    def segments(self) -> ArcSegments:
        """The path as arc segments, with consecutive edges of equal curvature merged."""
        deltas = manifold_of(self.path.group).minus(self.waypoints[1:], self.waypoints[:-1])
        is_moving = np.abs(deltas).max(axis=1) > _MIN_LENGTH
        waypoints = self.waypoints[np.append(True, is_moving)]
        deltas = deltas[is_moving]
        signed_lengths, turning_angles = deltas[:, self.car_index], deltas[:, self.car_index + 2]
        divisors = np.where(np.abs(signed_lengths) > _MIN_LENGTH, signed_lengths, np.inf)
        max_curvature = 1 / self.steering.turning_radius
        curvatures = np.clip(turning_angles / divisors, -max_curvature, max_curvature)
        segments = ArcSegments(signed_lengths, curvatures, waypoints[:, self.other_indices])
        i = 0
        while i + 1 < len(segments):
            if _is_continued(segments, i):
                segments = segments.merged(i)
            else:
                i += 1
        return segments

    def to_path(self, segments: ArcSegments) -> JointPath:
        """Return segments that end at the goal as a path; long arcs are cut."""
        counts = np.maximum(
            1, np.ceil(np.abs(segments.turning_angles) / _MAX_TURNING_ANGLE)
        ).astype(int)
        owning_segments = np.repeat(np.arange(len(segments)), counts)
        part_numbers = np.arange(len(owning_segments)) - np.repeat(
            np.cumsum(counts) - counts, counts
        )
        begin_positions = (
            segments.other_positions[owning_segments]
            + (part_numbers / counts[owning_segments])[:, None]
            * segments.other_displacements[owning_segments]
        )
        other_positions = np.concatenate([begin_positions, segments.other_positions[-1:]])
        parts = ArcSegments(
            segments.signed_lengths[owning_segments] / counts[owning_segments],
            segments.curvatures[owning_segments],
            other_positions,
        )
        points, yaws = knot_poses(self.start, parts)
        waypoints = self.positions(
            np.stack([points.real, points.imag, yaws], axis=1), other_positions
        )
        waypoints[-1] = self.waypoints[-1]
        return JointPath(self.path.group, waypoints)

    def positions(
        self, poses: Float64[np.ndarray, "m 3"], other_positions: Float64[np.ndarray, "m k"]
    ) -> Array:
        """Return configurations of the whole group, shape (m, nq)."""
        configurations = np.empty((len(poses), self.waypoints.shape[1]))
        configurations[:, self.car_index : self.car_index + 3] = poses
        configurations[:, self.other_indices] = other_positions
        return configurations

    def limits_near_start(self, limits: JointLimits, fixed: tuple[int, ...]) -> JointLimits:
        """Return limits, with those of angles on a circle shifted by full turns to the start.

        Coordinates in `fixed` get equal lower and upper limits.
        """
        is_wrapping = [wrap for joint in self.path.group.joints for wrap in joint.wraps]
        is_bounded = np.array(is_wrapping) & np.isfinite(limits.lower) & np.isfinite(limits.upper)
        bounded = np.flatnonzero(is_bounded)
        lower, upper = np.array(limits.lower), np.array(limits.upper)
        offsets = self.waypoints[0, bounded] - (lower[bounded] + upper[bounded]) / 2
        shifts = 2 * np.pi * np.round(offsets / (2 * np.pi))
        lower[bounded], upper[bounded] = lower[bounded] + shifts, upper[bounded] + shifts
        lower[list(fixed)] = upper[list(fixed)] = self.waypoints[0, list(fixed)]
        return replace(limits, lower=lower, upper=upper)


def _is_continued(segments: ArcSegments, i: int) -> bool:
    """Return whether segment i + 1 continues segment i with equal direction and curvature."""
    first, second = segments.signed_lengths[i : i + 2]
    direction_differences = (
        segments.other_displacements[i] * second - segments.other_displacements[i + 1] * first
    )
    return bool(
        first * second > 0
        and abs(segments.curvatures[i] - segments.curvatures[i + 1]) <= _MERGE_TOLERANCE
        and (np.abs(direction_differences) <= _MERGE_TOLERANCE * abs(first * second)).all()
    )
