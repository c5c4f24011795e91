"""BallTarget: target poses of a tool frame within a weighted distance of a center pose."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.value import Value
from planning.goals.targets.tool_target import POSE_TOLERANCE, ToolTarget
from planning.goals.targets.workspace_bound import WorkspaceBound

# Finite bound for the solvers, which accept no infinite box; larger than any arm [m].
_FINITE_BOUND = 1e3


@dataclass(frozen=True, eq=False)
class BallTarget(Value):
    """Target of a tool frame T: the poses X_WT with d(X_WT) <= tolerance.

    d = sqrt(sum (w_i t_i)^2 + (w_r theta)^2), with t the vector from G's origin to T's in the axes
    of a frame A [m], theta the angle between G and T [rad], and the weights w = (x, y, z, r).

    Attributes:
        frame: Full name of T.
        pose: X_WG, the center.
        weights: w, none negative, shape (4,).
        tolerance: Largest weighted distance d, positive.
        axes: R_WA, a unit quaternion, shape (4,).
    """

    frame: str
    pose: Pose
    weights: Float64[np.ndarray, "4"]
    tolerance: float
    axes: Float64[np.ndarray, "4"]

    def distances(self, tool_poses: Float64[np.ndarray, "n 4 4"]) -> Float64[np.ndarray, " n"]:
        """Return the weighted distance d of each X_WT to the center."""
        shift = (tool_poses[:, :3, 3] - self.pose.position) @ rotation.matrix(self.axes)
        # |R_1 - R_2| = sqrt(8) sin(angle / 2).
        change = tool_poses[:, :3, :3] - self.pose.matrix[:3, :3]
        chord = np.linalg.norm(change, axis=(1, 2)) / np.sqrt(8)
        turn = 2 * np.arcsin(np.minimum(chord, 1.0))
        return np.hypot(np.linalg.norm(shift * self.weights[:3], axis=1), self.weights[3] * turn)

    def are_met_by(self, tool_poses: Float64[np.ndarray, "n 4 4"]) -> Bool[np.ndarray, " n"]:
        """Return whether each X_WT is in the ball, up to the accuracy of the IK solvers."""
        accuracy = 2 * POSE_TOLERANCE * float(np.linalg.norm(self.weights))
        return self.distances(tool_poses) <= self.tolerance + accuracy

    def closest(self, tool_pose: Pose) -> Pose:
        """Return X_WT if it is in the ball, else the interpolated pose at d = tolerance."""
        distance = float(self.distances(tool_pose.matrix[None])[0])
        if distance <= self.tolerance:
            return tool_pose
        fraction = self.tolerance / distance
        inverse = rotation.conjugate(self.pose.quaternion)
        turn = fraction * rotation.log(rotation.multiply(inverse, tool_pose.quaternion))
        shift = fraction * (tool_pose.position - self.pose.position)
        turned = rotation.multiply(self.pose.quaternion, rotation.exp(turn))
        return Pose.from_parts(self.pose.position + shift, turned)

    def pose_errors(
        self, tool_poses: Float64[np.ndarray, "n 4 4"]
    ) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, " n"]]:
        """Return the translation [m] and rotation [rad] errors of each X_WT to its `closest`."""
        poses = [Pose.from_matrix(x_wt) for x_wt in tool_poses]
        errors = [self.closest(pose).distance(pose) for pose in poses]
        shift, turn = np.reshape(errors, (-1, 2)).T
        return shift, turn

    def widened_tolerances(self, tool_pose: Pose) -> tuple[Array, Array]:
        """Return position [m] and rotation [rad] tolerances about G that include X_WT."""
        error = self.pose.inverse @ tool_pose
        turn = float(np.linalg.norm(rotation.log(error.quaternion)))
        return np.abs(error.position), np.full(3, turn)

    def sample_poses(
        self, count: int, workspace: WorkspaceBound, rng: np.random.Generator
    ) -> tuple[Float64[np.ndarray, "count 3"], Float64[np.ndarray, "count 4"]]:
        """Return poses X_WT sampled over the ball, G itself first: positions and quaternions.

        Along axes without weight samples extend to the workspace bound.
        """
        unit_samples = rng.normal(size=(count, 6))
        scales = rng.uniform(size=count) ** (1 / 6) / np.linalg.norm(unit_samples, axis=1)
        unit_samples *= scales[:, None]
        unit_samples[:1] = 0.0
        max_shift = workspace.radius + float(np.linalg.norm(workspace.center - self.pose.position))
        shifts = unit_samples[:, :3] * np.minimum(self._half_widths[:3], max_shift)
        turns = unit_samples[:, 3:] * min(self._half_widths[3], np.pi)
        positions = self.pose.position + rotation.rotate(self.axes, shifts)
        turned = rotation.multiply(self.pose.quaternion, rotation.exp(turns))
        return positions, rotation.normalized(turned)

    @property
    def inscribed_target(self) -> ToolTarget:
        """Inscribed target: a position box and a rotation bound about G, all inside the ball."""
        shift = min(float(self._half_widths[:3].min()) / np.sqrt(6), _FINITE_BOUND)
        turn = self._half_widths[3] / np.sqrt(2)
        return ToolTarget(self.frame, self.pose, np.full(3, shift), np.full(3, turn))

    @property
    def position_tolerance(self) -> Float64[np.ndarray, "3"]:
        """Half-widths of the ball along A's axes [m], shape (3,)."""
        return self._half_widths[:3]

    @property
    def rotation_tolerance(self) -> Float64[np.ndarray, "3"]:
        """Largest angle of the ball [rad], repeated for the three axes."""
        return np.full(3, self._half_widths[3])

    @property
    def _half_widths(self) -> Array:
        """Half-widths along x, y, z of A [m] and in angle [rad], each taken alone, shape (4,)."""
        return self.tolerance / np.maximum(self.weights, 1e-12)
