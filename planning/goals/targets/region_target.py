"""RegionTarget: target region of tool-frame poses in world, all of them equally good."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.value import Value
from planning.goals.targets.tool_target import POSE_TOLERANCE
from planning.goals.targets.workspace_bound import WorkspaceBound

# Positions drawn per requested one: the others may be out of reach.
_DRAWS = 8


@dataclass(frozen=True, eq=False)
class RegionTarget(Value):
    """Target region of a tool frame T; `RegionGoal` defines which poses are in it.

    Attributes:
        frame: Full name of T.
        pose: X_WG, the center.
        position_tolerance: Half-widths of the box [m], as of RegionGoal, shape (3,).
        rotation_tolerance: Bounds on the rotation [rad], as of RegionGoal, shape (3,).
    """

    frame: str
    pose: Pose
    position_tolerance: Float64[np.ndarray, "3"]
    rotation_tolerance: Float64[np.ndarray, "3"]

    def are_met_by(self, reached: Float64[np.ndarray, "n 4 4"]) -> Bool[np.ndarray, " n"]:
        """Return whether each X_WT is in the region, up to the accuracy of the IK solvers."""
        shift, turn = self.misses(reached)
        return (shift <= 2 * POSE_TOLERANCE) & (turn <= 2 * POSE_TOLERANCE)

    def misses(
        self, reached: Float64[np.ndarray, "n 4 4"]
    ) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, " n"]]:
        """Return the translation [m] and rotation [rad] errors of each X_WT to its `closest`."""
        poses = [Pose.from_matrix(x_wt) for x_wt in reached]
        found = [self.closest(pose).distance(pose) for pose in poses]
        shift, turn = np.reshape(found, (-1, 2)).T
        return shift, turn

    def closest(self, reached: Pose) -> Pose:
        """Return X_WT if it is in the region, else a pose of the region close to it.

        Not promised: the closest one.
        """
        error = self.pose.inverse @ reached
        box = self.position_tolerance
        turn = self._clipped(error.quaternion)
        return self.pose @ Pose(np.clip(error.position, -box, box), turn)

    def widened(self, reached: Pose) -> tuple[Array, Array]:
        """Return position [m] and rotation [rad] tolerances that also include X_WT."""
        error = self.pose.inverse @ reached
        free, bounds = self._free, self.rotation_tolerance
        vector = rotation.log(error.quaternion)
        if 0 < free.sum() < 3:
            axis = int(np.flatnonzero(free if free.sum() == 1 else ~free)[0])
            tilt, twist = _tilt_and_twist(error.quaternion, axis)
            vector = tilt if free.sum() == 1 else twist * np.eye(3)[axis]
        turn = np.where(free, bounds, np.maximum(bounds, np.abs(vector)))
        return np.maximum(np.abs(error.position), self.position_tolerance), turn

    def samples(
        self, count: int, reach: WorkspaceBound, rng: np.random.Generator
    ) -> tuple[Float64[np.ndarray, "count 3"], Float64[np.ndarray, "count 4"]]:
        """Return X_WT sampled over the reachable part of the region, G itself first: p and R.

        Only the position is restricted to the workspace bound.
        """
        middle = self.pose
        shifts, turns = self._positions(count, reach, rng), self._turns(count, rng)
        positions = middle.position + rotation.rotate(middle.quaternion, shifts)
        turns = rotation.normalized(rotation.multiply(middle.quaternion, turns))
        positions = np.concatenate([middle.position[None], positions])[:count]
        return positions, np.concatenate([middle.quaternion[None], turns])[:count]

    @property
    def _free(self) -> Any:
        return self.rotation_tolerance >= np.pi

    def _clipped(self, turn: Array) -> Array:
        """Return R_GT clipped to the rotation tolerance."""
        free, bounds = self._free, self.rotation_tolerance
        if free.all():
            return turn
        if not free.any():
            return rotation.exp(np.clip(rotation.log(turn), -bounds, bounds))
        axis = int(np.flatnonzero(free if free.sum() == 1 else ~free)[0])
        tilt, twist = _tilt_and_twist(turn, axis)
        if free.sum() == 1:
            tilt = np.where(free, 0.0, np.clip(tilt, -bounds, bounds))
        else:
            twist = float(np.clip(twist, -bounds[axis], bounds[axis]))
        return rotation.multiply(rotation.exp(tilt), rotation.exp(twist * np.eye(3)[axis]))

    def _turns(self, count: int, rng: np.random.Generator) -> Array:
        """Return random rotations R_GT within tolerance, as quaternions, shape (count, 4)."""
        free, bounds = self._free, self.rotation_tolerance
        anywhere = rng.normal(size=(count, 4))
        anywhere /= np.linalg.norm(anywhere, axis=1, keepdims=True)
        if free.all():
            return anywhere
        vectors = rng.uniform(-1.0, 1.0, (count, 3)) * np.minimum(bounds, np.pi)
        if not free.any():
            return rotation.exp(_within_half_a_turn(vectors))
        axis = int(np.flatnonzero(free if free.sum() == 1 else ~free)[0])
        e = np.eye(3)[axis]
        twist = rotation.exp(vectors * e)
        if free.sum() == 1:
            return rotation.multiply(rotation.exp(_within_half_a_turn(vectors * (1 - e))), twist)
        tilts, _ = _tilts_and_twists(anywhere, axis)
        return rotation.multiply(rotation.exp(tilts), twist)

    def _positions(self, count: int, reach: WorkspaceBound, rng: np.random.Generator) -> Array:
        """Return random positions in the box, within the workspace bound where they meet.

        The shape is (count, 3), in G's axes [m].
        """
        box = self.position_tolerance
        center = (self.pose.inverse @ Pose.from_parts(reach.center)).position
        lower = np.clip(center - reach.radius, -box, box)
        upper = np.clip(center + reach.radius, -box, box)
        drawn = rng.uniform(lower, upper, (_DRAWS * count, 3))
        is_near = np.linalg.norm(drawn - center, axis=1) <= reach.radius
        near = drawn[is_near] if is_near.any() else drawn
        return np.resize(near, (count, 3))


def _tilt_and_twist(turn: Array, axis: int) -> tuple[Array, float]:
    tilts, twists = _tilts_and_twists(turn[None], axis)
    return tilts[0], float(twists[0])


def _tilts_and_twists(turns: Array, axis: int) -> tuple[Array, Array]:
    """Return the swing-twist decomposition R = exp(tilt) exp(twist e), tilt orthogonal to e."""
    twists = 2 * np.arctan2(turns[:, 1 + axis], turns[:, 0])
    twists = np.remainder(twists + np.pi, 2 * np.pi) - np.pi
    untwisted = rotation.exp(-twists[:, None] * np.eye(3)[axis])
    return rotation.log(rotation.multiply(turns, untwisted)), twists


def _within_half_a_turn(vectors: Array) -> Array:
    """Return rotation vectors with their norms limited to pi."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors * np.minimum(1.0, np.pi / np.maximum(length, 1e-300))
