"""SteeringPaths: steering function of a group with a car, from any configuration to any other.

The car follows its shortest curve (Dubins or Reeds-Shepp); the other joints move along straight
lines, in proportion to the distance that the car has covered. A steering path is waypoints joined
by arcs and lines of constant velocity (`SteeredManifold`).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.steering import SteeredManifold, steering_of
from planning.errors import ProblemInvalid
from planning.search.cars.dubins import dubins_words
from planning.search.cars.path_words import PathWords
from planning.search.cars.reeds_shepp import reeds_shepp_words

# Largest angle of one arc [rad], well below half a turn, where its direction would be ambiguous.
_MAX_ARC_ANGLE = 2.0
# Tolerance on lateral slip and curvature of an arc, as a share of its length: rounding.
_ROUNDING = 1e-7
# Segments of at most this length do not count [radii].
_MIN_SEGMENT_LENGTH = 1e-10


@dataclass(frozen=True)
class SteeringPath:
    """Path of arcs and lines from one configuration to another.

    Attributes:
        waypoints: Both ends included, shape (k + 1, nq), k >= 1.
        deltas: The arcs and lines between them, as tangents, shape (k, nv).
    """

    waypoints: Float64[np.ndarray, "m nq"]
    deltas: Float64[np.ndarray, "k nv"]


class SteeringPaths:
    """Steering function of one group with a car.

    Attributes:
        manifold: Manifold whose geodesics are the car's arcs and lines.
        steering: Turning radius and directions of the car.
        iq: Index of the car's first coordinate in q.
        iv: Index of the car's first coordinate in v.
    """

    def __init__(self, group: JointGroup) -> None:
        """Prepare for a group with one car.

        Raises:
            ProblemInvalid: The group has several cars.
        """
        cars = steering_of(group)
        if len(cars) > 1:
            message = f"a group may have one car; this one has {sorted(cars)}"
            raise ProblemInvalid(message, {"field": "group", "cars": sorted(cars)})
        self.manifold = SteeredManifold(group.joints, tuple(cars))
        self.steering = next(iter(cars.values()))
        self.iq, self.iv = self.manifold.offsets[0]

    def steer(self, q0: Float64[np.ndarray, " nq"], q1: Float64[np.ndarray, " nq"]) -> SteeringPath:
        """Return the steering path from q0 to q1.

        It is the single arc through both if the car can drive it, or else the car's shortest curve.
        For a car that may drive backwards, the path from q1 to q0 is the same one reversed.
        """
        if self.steering.reverse and q1.tolist() < q0.tolist():
            reverse_path = self._steer(q1, q0)
            return SteeringPath(reverse_path.waypoints[::-1], -reverse_path.deltas[::-1])
        return self._steer(q0, q1)

    def waypoints_through(self, waypoints: Float64[np.ndarray, "n nq"]) -> Array:
        """Return the waypoints of the steering paths between given ones, these included."""
        pieces = [self.steer(q0, q1).waypoints[1:] for q0, q1 in pairwise(waypoints)]
        return np.concatenate([waypoints[:1], *pieces])

    def tangents(
        self, q0s: Float64[np.ndarray, "m nq"], q1s: Float64[np.ndarray, "m nq"]
    ) -> Float64[np.ndarray, "m k nv"]:
        """Return the tangents of the segments, in order, of the steering paths between rows."""
        deltas = self.manifold.minus(q1s, q0s)
        is_arc = self._are_arcs(deltas)
        tangents = self._segment_tangents(q0s, q1s, deltas)
        tangents[is_arc] = 0.0
        tangents[is_arc, 0] = deltas[is_arc]
        return tangents

    def path_of_segments(
        self,
        q0: Float64[np.ndarray, " nq"],
        q1: Float64[np.ndarray, " nq"],
        segments: Float64[np.ndarray, "k nv"],
    ) -> SteeringPath:
        """Return the path from q0 to q1 whose segments have given tangents; long arcs are cut."""
        segments = segments[np.abs(segments).max(axis=1) > _MIN_SEGMENT_LENGTH]
        counts = np.ceil(np.abs(segments[:, self.iv + 2]) / _MAX_ARC_ANGLE).astype(int)
        counts = np.maximum(counts, 1)
        deltas = np.repeat(segments / counts[:, None], counts, axis=0)
        rows = [q0]
        for delta in deltas[:-1]:
            rows.append(self.manifold.plus(rows[-1], delta))
        return SteeringPath(np.stack([*rows, q1]), deltas)

    def _steer(self, q0: Array, q1: Array) -> SteeringPath:
        delta = self.manifold.minus(q1, q0)[None]
        if self._are_arcs(delta)[0]:
            return SteeringPath(np.stack([q0, q1]), delta)
        return self.path_of_segments(q0, q1, self._segment_tangents(q0[None], q1[None], delta)[0])

    def _are_arcs(self, deltas: Float64[np.ndarray, "m nv"]) -> Bool[np.ndarray, " m"]:
        """Return which tangents are single arcs (or lines) that the car can drive."""
        forward, lateral, angle = (deltas[:, self.iv + i] for i in range(3))
        size = np.abs(forward) + _MIN_SEGMENT_LENGTH
        return (
            (np.abs(lateral) <= _ROUNDING * size)
            & (np.abs(angle) * self.steering.turning_radius <= np.abs(forward) + _ROUNDING * size)
            & (np.abs(angle) <= _MAX_ARC_ANGLE)
            & (self.steering.reverse | (forward >= -_MIN_SEGMENT_LENGTH))
        )

    def _segment_tangents(self, q0s: Array, q1s: Array, deltas: Array) -> Array:
        """Return the tangents of all segments of the shortest curves, shape (m, k, nv)."""
        words = self._words(q0s, q1s)
        sizes = np.abs(words.lengths)
        fractions = sizes / np.maximum(sizes.sum(axis=1, keepdims=True), _MIN_SEGMENT_LENGTH)
        tangents = fractions[:, :, None] * deltas[:, None]
        tangents[:, :, self.iv] = words.lengths * self.steering.turning_radius
        tangents[:, :, self.iv + 1] = 0.0
        tangents[:, :, self.iv + 2] = words.lengths * words.turns
        return tangents

    def _words(self, q0s: Array, q1s: Array) -> PathWords:
        poses = [q[:, self.iq : self.iq + 3] for q in (q0s, q1s)]
        x, y, yaw = (poses[1] - poses[0]).T
        c, s = np.cos(poses[0][:, 2]), np.sin(poses[0][:, 2])
        radius = self.steering.turning_radius
        goals = np.stack([(c * x + s * y) / radius, (c * y - s * x) / radius, yaw], axis=1)
        return (reeds_shepp_words if self.steering.reverse else dubins_words)(goals)
