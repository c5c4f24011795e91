"""Jumps: sums of the discontinuities of a trajectory between its pieces.

A robot makes no jump. Without its jumps, each removed from its instant on, the motion is
continuous, has the same rates, and differs by the sum of the jumps so far. So the relevant quantity
is not the largest jump but the largest sum of jumps between any two instants: the motion exceeds
the change that its rates allow by that much, within any time, however short.

The largest sum of consecutive jumps, signs counted, is the range of their partial sums. Rotations
are not additive; for them sizes are added, which is an upper bound.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointType, offsets_of

_FULL_TURN = 2 * np.pi


@dataclass(frozen=True)
class JumpSums:
    """Partial sums of consecutive jumps.

    Attributes:
        partial: Sums of the first 1, 2, ... jumps, shape (n, nv).
        largest: Largest sum between any two instants, by coordinate, shape (nv,).
    """

    partial: Float64[np.ndarray, "n nv"]
    largest: Float64[np.ndarray, " nv"]

    @classmethod
    def of(cls, jumps: Float64[np.ndarray, "n nv"]) -> "JumpSums":
        """Build from consecutive jumps."""
        partial = np.cumsum(jumps, axis=0)
        return cls(partial, partial.max(axis=0, initial=0.0) - partial.min(axis=0, initial=0.0))

    def split(self, count: int) -> tuple["JumpSums", "JumpSums"]:
        """Return the sums of the first `count` coordinates, and those of the others."""
        partial, sizes = self.partial, self.largest
        return JumpSums(partial[:, :count], sizes[:count]), JumpSums(
            partial[:, count:], sizes[count:]
        )

    def last_jump(self, column: int) -> int:
        """Return the index of the jump that completes the largest sum of a coordinate."""
        partial = self.partial[:, column]
        above, below = int(np.argmax(partial)), int(np.argmin(partial))
        # The sums before any jump are 0.
        ends = [at for at, sign in ((above, 1), (below, -1)) if sign * partial[at] > 0]
        return max(ends, default=0)


def position_jumps(
    trajectory: TimedTrajectory,
    begins: Float64[np.ndarray, "n nq"],
    ends: Float64[np.ndarray, "n nq"],
) -> Float64[np.ndarray, "n-1 nv"]:
    """Return the jump from each piece's end to the next piece's beginning, shape (n - 1, nv).

    Args:
        trajectory: The motion.
        begins: Configurations at the beginnings of its pieces.
        ends: Configurations at the ends of its pieces.
    """
    jumps = trajectory.manifold.minus(begins[1:], ends[:-1])
    if trajectory.manifold.is_flat:
        return jumps
    for _, iv in offsets_of(trajectory.joints, lambda joint: joint.type is JointType.FLOATING):
        jumps[:, iv] = np.linalg.norm(jumps[:, iv : iv + 3], axis=1)
        jumps[:, iv + 1 : iv + 3] = 0.0
    return jumps


def unwrap_turns(trajectory: TimedTrajectory) -> TimedTrajectory:
    """Return the same motion without whole-turn jumps between the base configurations.

    Only for joints on a circle, where whole turns make no difference.
    """
    if not any(trajectory.manifold.wraps) or trajectory.num_pieces == 1:
        return trajectory
    is_circular = _circular_coordinates(trajectory)
    q = trajectory.bases[:, is_circular]
    columns = np.flatnonzero(np.array(trajectory.manifold.wraps))
    widths = np.diff(trajectory.breaks)
    powers = widths[:, None] ** np.arange(trajectory.coefficients.shape[1])
    coefficients = trajectory.coefficients[:, :, columns]
    ends = q + np.einsum("nk,nkv->nv", powers, coefficients)
    turns = np.round((q[1:] + coefficients[1:, 0] - ends[:-1]) / _FULL_TURN)
    if not turns.any():
        return trajectory
    bases = np.array(trajectory.bases)
    bases[1:, is_circular] -= _FULL_TURN * np.cumsum(turns, axis=0)
    return replace(trajectory, bases=bases)


def _circular_coordinates(trajectory: TimedTrajectory) -> Bool[np.ndarray, " nq"]:
    """Return which coordinates of q are on a circle."""
    flags: list[bool] = []
    for joint in trajectory.joints:
        is_floating = joint.type is JointType.FLOATING
        flags += [False] * 7 if is_floating else list(joint.wraps)
    return np.array(flags, dtype=bool)
