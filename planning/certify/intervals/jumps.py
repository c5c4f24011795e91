"""What happens where pieces meet: how far jumps add up.

A robot makes no jump. Take the motion's jumps out, each from where it is on, and what is left is
continuous, has the same rates, and is off by the sum of the jumps until then. So what matters is
not the largest jump but the largest sum of jumps between any two instants: by so much more than its
rates allow the motion changes within some time, however short.

The largest sum of consecutive jumps, signs counted, is the range of their partial sums. Rotations
do not add up like numbers; of them sizes are added, which is no less.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointType, offsets_of

type Array = np.ndarray[Any, np.dtype[np.float64]]

_TURN = 2 * np.pi


@dataclass(frozen=True)
class Sums:
    """Sums of consecutive jumps.

    Attributes:
        partial: Of the first jumps, one more in each row, shape (n, nv).
        sizes: The largest between any two instants, of each coordinate, shape (nv,).
    """

    partial: Float64[np.ndarray, "n nv"]
    sizes: Float64[np.ndarray, " nv"]

    @classmethod
    def of(cls, jumps: Float64[np.ndarray, "n nv"]) -> "Sums":
        """Add up jumps that come one after another."""
        partial = np.cumsum(jumps, axis=0)
        return cls(partial, partial.max(axis=0, initial=0.0) - partial.min(axis=0, initial=0.0))

    def parted(self, count: int) -> tuple["Sums", "Sums"]:
        """Return the sums of the first so many coordinates, and those of the others."""
        partial, sizes = self.partial, self.sizes
        return Sums(partial[:, :count], sizes[:count]), Sums(partial[:, count:], sizes[count:])

    def last_of(self, column: int) -> int:
        """Return the jump with which the largest sum of a coordinate is complete."""
        partial = self.partial[:, column]
        above, below = int(np.argmax(partial)), int(np.argmin(partial))
        # The sums before any jump are 0.
        ends = [at for at, sign in ((above, 1), (below, -1)) if sign * partial[at] > 0]
        return max(ends, default=0)


def position_jumps(
    trajectory: TimedTrajectory,
    begins: Float64[np.ndarray, "n nq"],
    ends: Float64[np.ndarray, "n nq"],
) -> Float64[np.ndarray, "n nv"]:
    """Return by how much each piece begins off the end of the one before it, but for the first.

    Args:
        trajectory: The motion.
        begins: Where its pieces begin.
        ends: And where they end.
    """
    jumps = trajectory.manifold.minus(begins[1:], ends[:-1])
    if trajectory.manifold.is_flat:
        return jumps
    for _, iv in offsets_of(trajectory.joints, lambda joint: joint.type is JointType.FLOATING):
        jumps[:, iv] = np.linalg.norm(jumps[:, iv : iv + 3], axis=1)
        jumps[:, iv + 1 : iv + 3] = 0.0
    return jumps


def in_one_turn(trajectory: TimedTrajectory) -> TimedTrajectory:
    """Return the same motion with pieces that are not anchored whole turns off one another.

    Only of joints on a circle, where whole turns are nothing.
    """
    if not any(trajectory.manifold.wraps) or trajectory.num_pieces == 1:
        return trajectory
    circle = _circles(trajectory)
    q = trajectory.bases[:, circle]
    columns = np.flatnonzero(np.array(trajectory.manifold.wraps))
    widths = np.diff(trajectory.breaks)
    powers = widths[:, None] ** np.arange(trajectory.coefficients.shape[1])
    coefficients = trajectory.coefficients[:, :, columns]
    ends = q + np.einsum("nk,nkv->nv", powers, coefficients)
    turns = np.round((q[1:] + coefficients[1:, 0] - ends[:-1]) / _TURN)
    if not turns.any():
        return trajectory
    bases = np.array(trajectory.bases)
    bases[1:, circle] -= _TURN * np.cumsum(turns, axis=0)
    return replace(trajectory, bases=bases)


def _circles(trajectory: TimedTrajectory) -> Bool[np.ndarray, " nq"]:
    """Return which coordinates of q are on a circle."""
    flags: list[bool] = []
    for joint in trajectory.joints:
        is_floating = joint.type is JointType.FLOATING
        flags += [False] * 7 if is_floating else list(joint.wraps)
    return np.array(flags, dtype=bool)
