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
_CANDIDATES_PER_SAMPLE = 8


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

    def are_met_by(self, tool_poses: Float64[np.ndarray, "n 4 4"]) -> Bool[np.ndarray, " n"]:
        """Return whether each X_WT is in the region, up to the accuracy of the IK solvers."""
        shift, turn = self.pose_errors(tool_poses)
        return (shift <= 2 * POSE_TOLERANCE) & (turn <= 2 * POSE_TOLERANCE)

    def pose_errors(
        self, tool_poses: Float64[np.ndarray, "n 4 4"]
    ) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, " n"]]:
        """Return the translation [m] and rotation [rad] errors of each X_WT to its `closest`."""
        poses = [Pose.from_matrix(x_wt) for x_wt in tool_poses]
        errors = [self.closest(pose).distance(pose) for pose in poses]
        shift, turn = np.reshape(errors, (-1, 2)).T
        return shift, turn

    def closest(self, tool_pose: Pose) -> Pose:
        """Return X_WT if it is in the region, else a pose of the region close to it.

        Not promised: the closest one.
        """
        error = self.pose.inverse @ tool_pose
        box = self.position_tolerance
        turn = self._clip_rotation(error.quaternion)
        return self.pose @ Pose(np.clip(error.position, -box, box), turn)

    def widened_tolerances(self, tool_pose: Pose) -> tuple[Array, Array]:
        """Return position [m] and rotation [rad] tolerances that also include X_WT."""
        error = self.pose.inverse @ tool_pose
        is_free, bounds = self._is_free, self.rotation_tolerance
        vector = rotation.log(error.quaternion)
        if 0 < is_free.sum() < 3:
            axis = int(np.flatnonzero(is_free if is_free.sum() == 1 else ~is_free)[0])
            swing, twist = _swing_twist(error.quaternion, axis)
            vector = swing if is_free.sum() == 1 else twist * np.eye(3)[axis]
        turn = np.where(is_free, bounds, np.maximum(bounds, np.abs(vector)))
        return np.maximum(np.abs(error.position), self.position_tolerance), turn

    def sample_poses(
        self, count: int, workspace: WorkspaceBound, rng: np.random.Generator
    ) -> tuple[Float64[np.ndarray, "count 3"], Float64[np.ndarray, "count 4"]]:
        """Return X_WT sampled over the reachable part of the region, G itself first: p and R.

        Only the position is restricted to the workspace bound.
        """
        center = self.pose
        shifts = self._sample_positions(count, workspace, rng)
        turns = self._sample_rotations(count, rng)
        positions = center.position + rotation.rotate(center.quaternion, shifts)
        turns = rotation.normalized(rotation.multiply(center.quaternion, turns))
        positions = np.concatenate([center.position[None], positions])[:count]
        return positions, np.concatenate([center.quaternion[None], turns])[:count]

    @property
    def _is_free(self) -> Any:
        return self.rotation_tolerance >= np.pi

    def _clip_rotation(self, turn: Array) -> Array:
        """Return R_GT clipped to the rotation tolerance."""
        is_free, bounds = self._is_free, self.rotation_tolerance
        if is_free.all():
            return turn
        if not is_free.any():
            return rotation.exp(np.clip(rotation.log(turn), -bounds, bounds))
        axis = int(np.flatnonzero(is_free if is_free.sum() == 1 else ~is_free)[0])
        swing, twist = _swing_twist(turn, axis)
        if is_free.sum() == 1:
            swing = np.where(is_free, 0.0, np.clip(swing, -bounds, bounds))
        else:
            twist = float(np.clip(twist, -bounds[axis], bounds[axis]))
        return rotation.multiply(rotation.exp(swing), rotation.exp(twist * np.eye(3)[axis]))

    def _sample_rotations(self, count: int, rng: np.random.Generator) -> Array:
        """Return random rotations R_GT within tolerance, as quaternions, shape (count, 4)."""
        is_free, bounds = self._is_free, self.rotation_tolerance
        random_quaternions = rng.normal(size=(count, 4))
        random_quaternions /= np.linalg.norm(random_quaternions, axis=1, keepdims=True)
        if is_free.all():
            return random_quaternions
        vectors = rng.uniform(-1.0, 1.0, (count, 3)) * np.minimum(bounds, np.pi)
        if not is_free.any():
            return rotation.exp(_limit_to_half_turn(vectors))
        axis = int(np.flatnonzero(is_free if is_free.sum() == 1 else ~is_free)[0])
        e = np.eye(3)[axis]
        twist = rotation.exp(vectors * e)
        if is_free.sum() == 1:
            return rotation.multiply(rotation.exp(_limit_to_half_turn(vectors * (1 - e))), twist)
        swings, _ = _swings_and_twists(random_quaternions, axis)
        return rotation.multiply(rotation.exp(swings), twist)

    def _sample_positions(
        self, count: int, workspace: WorkspaceBound, rng: np.random.Generator
    ) -> Array:
        """Return random positions in the box, within the workspace bound where they meet.

        The shape is (count, 3), in G's axes [m].
        """
        box = self.position_tolerance
        center = (self.pose.inverse @ Pose.from_parts(workspace.center)).position
        lower = np.clip(center - workspace.radius, -box, box)
        upper = np.clip(center + workspace.radius, -box, box)
        candidates = rng.uniform(lower, upper, (_CANDIDATES_PER_SAMPLE * count, 3))
        is_near = np.linalg.norm(candidates - center, axis=1) <= workspace.radius
        near = candidates[is_near] if is_near.any() else candidates
        return np.resize(near, (count, 3))


def _swing_twist(turn: Array, axis: int) -> tuple[Array, float]:
    swings, twists = _swings_and_twists(turn[None], axis)
    return swings[0], float(twists[0])


def _swings_and_twists(turns: Array, axis: int) -> tuple[Array, Array]:
    """Return the swing-twist decomposition R = exp(swing) exp(twist e), swing orthogonal to e."""
    twists = 2 * np.arctan2(turns[:, 1 + axis], turns[:, 0])
    twists = np.remainder(twists + np.pi, 2 * np.pi) - np.pi
    untwisted = rotation.exp(-twists[:, None] * np.eye(3)[axis])
    return rotation.log(rotation.multiply(turns, untwisted)), twists


def _limit_to_half_turn(vectors: Array) -> Array:
    """Return rotation vectors with their norms limited to pi."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors * np.minimum(1.0, np.pi / np.maximum(length, 1e-300))
