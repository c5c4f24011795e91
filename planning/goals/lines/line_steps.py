"""LineSteps: predictor-corrector steps of differential IK along tool lines, many lines at once.

The predictor follows the resolved rates q' = J^+ t of the line's twist t; the corrector is Newton's
method on the pose error, with damped least squares J^T (J J^T + lambda^2 I)^-1 (Nakamura and
Hanafusa 1986, Wampler 1986), so that it stays small where J has lost rank.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.geometry import rotation
from planning.domain.goals.linear_moves import ToolLine
from planning.domain.robot.manifold import Manifold
from planning.world.mechanics.tool_kinematics import ToolKinematics

# Damping of the pseudoinverse at singular configurations.
_DAMPING = 1e-10
_ITERATIONS = 10
# Pose error that counts as zero [m and rad].
_POSE_TOLERANCE = 1e-9
# Largest correction as a share of its step: a larger one may lead to another IK branch.
_MAX_CORRECTION_RATIO = 0.5
# Largest joint motion in one step [rad or m].
_MAX_JOINT_STEP = 0.2
# Cap on the sum of joint motions in the exponent of the deviation bound, against overflow.
_MAX_EXPONENT = 50.0


class LineSteps:
    """Steps of configurations along lines of one tool frame; lines are referred to by row."""

    def __init__(
        self, kinematics: ToolKinematics, manifold: Manifold, lines: Sequence[ToolLine]
    ) -> None:
        """Prepare for a batch of lines."""
        self._kinematics = kinematics
        self._manifold = manifold
        self._origins = np.array([line.begin.position for line in lines])
        self._quaternions = np.array([line.begin.quaternion for line in lines])
        self._shifts = np.array([line.translation for line in lines])
        self._turns = np.array([line.rotation_vector for line in lines])
        world_turns = rotation.rotate(self._quaternions, self._turns)
        self._twists = np.concatenate([world_turns, self._shifts], axis=1)
        self.turn_angles = np.linalg.norm(self._turns, axis=1)

    def step(
        self,
        rows: Int64[np.ndarray, " m"],
        q: Float64[np.ndarray, "m nq"],
        spans: tuple[Float64[np.ndarray, " m"], Float64[np.ndarray, " m"]],
        locked: Bool[np.ndarray, "m nv"],
    ) -> tuple[Float64[np.ndarray, "m nq"], Bool[np.ndarray, " m"]]:
        """Return configurations at the far ends of spans of lines, and whether they converged.

        Converged means: no pose error, a small correction and joint motions of at most
        `_MAX_JOINT_STEP`.

        Args:
            rows: Rows of the lines.
            q: Configurations at the near ends of the spans.
            spans: Fractions of the line at the near and at the far ends.
            locked: Velocity coordinates that must not move.
        """
        near, far = spans
        twist = self._twists[rows] * (far - near)[:, None]
        predicted = self._manifold.plus(q, self._joint_displacements(q, twist, locked))
        predicted_length = np.linalg.norm(self._manifold.minus(predicted, q), axis=1)
        corrected = np.array(predicted)
        error = self._pose_errors(rows, corrected, far)
        for _ in range(_ITERATIONS):
            if np.abs(error).max(initial=0.0) <= _POSE_TOLERANCE:
                break
            correction = self._joint_displacements(corrected, error, locked)
            size = np.abs(correction).max(axis=1, keepdims=True)
            corrected = self._manifold.plus(
                corrected, correction * np.minimum(1.0, _MAX_JOINT_STEP / np.maximum(size, 1e-12))
            )
            error = self._pose_errors(rows, corrected, far)
        is_converged = np.abs(error).max(axis=1, initial=0.0) <= _POSE_TOLERANCE
        correction_length = np.linalg.norm(self._manifold.minus(corrected, predicted), axis=1)
        is_converged &= (
            correction_length <= _MAX_CORRECTION_RATIO * predicted_length + _POSE_TOLERANCE
        )
        is_converged &= (
            np.abs(self._manifold.minus(corrected, q)).max(axis=1, initial=0.0) <= _MAX_JOINT_STEP
        )
        return corrected, is_converged

    def deviation_bounds(
        self,
        rows: Int64[np.ndarray, " m"],
        q: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        width: Float64[np.ndarray, " m"],
    ) -> tuple[Float64[np.ndarray, " m"], Float64[np.ndarray, " m"]]:
        """Bound the tool's deviation from its line [m, rad] on joint geodesics between two points.

        With both ends exact, the deviation f satisfies |f| <= max |f''| / 8 on [0, 1]. With columns
        (a_i; v_i) of the Jacobian and rates w_i, p'' = sum_ij (a_i x v_j) w_i w_j over i before j
        along the chain, and in the same way |v_j| grows by at most exp(sum w); mimic joints count
        separately from their leaders, since both turn while the tool may not. For rotations the
        matrix R - S is bounded, where |R''| <= sqrt(2) (|omega'| + |omega|^2) in Frobenius' norm.

        Args:
            rows: Rows of the lines.
            q: Configurations at the beginning of the geodesics.
            displacements: Tangent displacements of the geodesics.
            width: Share of the line that each geodesic covers.
        """
        columns = self._kinematics.jacobians_with_followers(q)
        leaders, multipliers = self._kinematics.followers
        displacements = np.concatenate(
            [displacements, displacements[:, leaders] * multipliers], axis=1
        )
        rates = np.abs(displacements)
        angular_norms = np.linalg.norm(columns[:, :3], axis=1)
        linear_norms = np.linalg.norm(columns[:, 3:], axis=1)
        linear_norms += linear_norms.max(axis=1, keepdims=True) * np.expm1(
            np.minimum(rates.sum(axis=1, keepdims=True), _MAX_EXPONENT)
        )
        pairs = angular_norms[:, :, None] * linear_norms[:, None, :]
        pairs = np.maximum(pairs, pairs.transpose(0, 2, 1))
        shift = np.einsum("mi,mij,mj->m", rates, pairs, rates) / 8
        bending = np.square((angular_norms * rates).sum(axis=1)) / 2
        speed = (
            np.linalg.norm(np.einsum("mij,mj->mi", columns[:, :3], displacements), axis=1) + bending
        )
        steady = (self.turn_angles[rows] * width) ** 2
        chord = (bending + speed**2 + steady) / 8
        return shift, 2 * np.arcsin(np.minimum(chord / 2, 1.0))

    def twist(self, row: int) -> Array:
        """Return the twist of a whole line [rotation; translation] in W [rad, m], shape (6,)."""
        return self._twists[row]

    def _joint_displacements(self, q: Array, twists: Array, locked: Flags) -> Array:
        """Return the joint displacements of tool twists, by damped least squares."""
        jacobian = np.where(locked[:, None, :], 0.0, self._kinematics.jacobians(q))
        square = jacobian @ jacobian.transpose(0, 2, 1) + _DAMPING * np.eye(6)
        return np.einsum("mij,mi->mj", jacobian, np.linalg.solve(square, twists[..., None])[..., 0])

    def _pose_errors(self, rows: Indices, q: Array, fractions: Array) -> Array:
        """Return the pose errors to the lines at some fractions, as twists in W."""
        actual, positions = self._kinematics.poses(q)
        turned = rotation.exp(fractions[:, None] * self._turns[rows])
        desired = rotation.matrix(rotation.multiply(self._quaternions[rows], turned))
        error_rotation = desired @ actual.transpose(0, 2, 1)
        skew = error_rotation - error_rotation.transpose(0, 2, 1)
        axis = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1) / 2
        sine = np.linalg.norm(axis, axis=1)
        cosine = (np.trace(error_rotation, axis1=1, axis2=2) - 1) / 2
        angle = np.arctan2(sine, cosine)
        turn = axis * (angle / np.maximum(sine, 1e-300))[:, None]
        shift = self._origins[rows] + fractions[:, None] * self._shifts[rows] - positions
        return np.concatenate([turn, shift], axis=1)
