"""BallTarget: poses of a tool frame within a weighted distance of one."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.value import Value
from planning.goals.targets.tool_target import POSE_TOLERANCE, ToolTarget
from planning.goals.targets.workspace_bound import WorkspaceBound

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Wide enough for any arm; solvers take no infinite box [m].
_WIDE = 1e3


@dataclass(frozen=True, eq=False)
class BallTarget(Value):
    """Where the tool frame T shall be: d(X_WT) <= tolerance.

    d = sqrt(sum (w_i t_i)^2 + (w_r theta)^2), with t the way from G's origin to T's by the axes of
    a frame A [m], theta the angle between G and T [rad], and the weights w = (x, y, z, r).

    Attributes:
        frame: Full name of T.
        pose: X_WG.
        weights: w, none negative, shape (4,).
        tolerance: Positive.
        axes: R_WA, a unit quaternion, shape (4,).
    """

    frame: str
    pose: Pose
    weights: Float64[np.ndarray, "4"]
    tolerance: float
    axes: Float64[np.ndarray, "4"]

    def distances(self, reached: Float64[np.ndarray, "n 4 4"]) -> Float64[np.ndarray, " n"]:
        """Return d of each X_WT."""
        shift = (reached[:, :3, 3] - self.pose.position) @ rotation.matrix(self.axes)
        # |R_1 - R_2| = sqrt(8) sin(angle / 2).
        change = reached[:, :3, :3] - self.pose.matrix[:3, :3]
        chord = np.linalg.norm(change, axis=(1, 2)) / np.sqrt(8)
        turn = 2 * np.arcsin(np.minimum(chord, 1.0))
        return np.hypot(np.linalg.norm(shift * self.weights[:3], axis=1), self.weights[3] * turn)

    def are_met_by(self, reached: Float64[np.ndarray, "n 4 4"]) -> Bool[np.ndarray, " n"]:
        """Return whether each X_WT is that near, but for what a solver may miss."""
        missed = 2 * POSE_TOLERANCE * float(np.linalg.norm(self.weights))
        return self.distances(reached) <= self.tolerance + missed

    def closest(self, reached: Pose) -> Pose:
        """Return X_WT, or if it is too far the pose that far on the straight way to it."""
        distance = float(self.distances(reached.matrix[None])[0])
        if distance <= self.tolerance:
            return reached
        share = self.tolerance / distance
        inverse = rotation.conjugate(self.pose.quaternion)
        turn = share * rotation.log(rotation.multiply(inverse, reached.quaternion))
        shift = share * (reached.position - self.pose.position)
        turned = rotation.multiply(self.pose.quaternion, rotation.exp(turn))
        return Pose.from_parts(self.pose.position + shift, turned)

    def misses(
        self, reached: Float64[np.ndarray, "n 4 4"]
    ) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, " n"]]:
        """Return how far each X_WT is from its closest pose [m and rad]."""
        poses = [Pose.from_matrix(x_wt) for x_wt in reached]
        found = [self.closest(pose).distance(pose) for pose in poses]
        shift, turn = np.reshape(found, (-1, 2)).T
        return shift, turn

    def widened(self, reached: Pose) -> tuple[Array, Array]:
        """Return tolerances of a box and a rotation about G that X_WT is within."""
        error = self.pose.inverse @ reached
        turn = float(np.linalg.norm(rotation.log(error.quaternion)))
        return np.abs(error.position), np.full(3, turn)

    def samples(
        self, count: int, reach: WorkspaceBound, rng: np.random.Generator
    ) -> tuple[Float64[np.ndarray, "count 3"], Float64[np.ndarray, "count 4"]]:
        """Return poses X_WT spread over it, G itself first: p and R.

        Along axes without weight they go as far as the group reaches.
        """
        drawn = rng.normal(size=(count, 6))
        drawn *= (rng.uniform(size=count) ** (1 / 6) / np.linalg.norm(drawn, axis=1))[:, None]
        drawn[:1] = 0.0
        farthest = reach.radius + float(np.linalg.norm(reach.center - self.pose.position))
        shifts = drawn[:, :3] * np.minimum(self._widths[:3], farthest)
        turns = drawn[:, 3:] * min(self._widths[3], np.pi)
        positions = self.pose.position + rotation.rotate(self.axes, shifts)
        turned = rotation.multiply(self.pose.quaternion, rotation.exp(turns))
        return positions, rotation.normalized(turned)

    @property
    def inside(self) -> ToolTarget:
        """A box and a rotation about G that are all of them near enough."""
        shift = min(float(self._widths[:3].min()) / np.sqrt(6), _WIDE)
        turn = self._widths[3] / np.sqrt(2)
        return ToolTarget(self.frame, self.pose, np.full(3, shift), np.full(3, turn))

    @property
    def position_tolerance(self) -> Float64[np.ndarray, "3"]:
        """Half-widths by A's axes [m]."""
        return self._widths[:3]

    @property
    def rotation_tolerance(self) -> Float64[np.ndarray, "3"]:
        """Of the angle [rad], three times the same."""
        return np.full(3, self._widths[3])

    @property
    def _widths(self) -> Array:
        """How far it goes along x, y, z [m] and in angle [rad], each by itself."""
        return self.tolerance / np.maximum(self.weights, 1e-12)
