"""JointBounds: positions, rates and jumps of every joint by itself, all by one call of the kernel.

They are those of `limit_checks` and `end_checks`, which compute them in numpy for all other joints:
floating and planar ones, those that wrap, and those with followers. Bernstein coefficients are
within the same rounding errors (`intervals/rounding`).
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from planning.certify.intervals.rounding import LOW_DEGREE
from planning.domain.arrays import Array, Indices
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.kernel.native import native

# Largest excess of the bound on positions over the true peak [rad or m].
POSITION_GAP = 1e-8
# Largest excess of the bound on rates over the true peak, relative to their limits.
RATE_GAP = 1e-8


@dataclass(frozen=True)
class JointPeak:
    """An upper bound on a peak, and where it is.

    Attributes:
        value: The bound.
        row: Of a rate the joint, of positions the upper bounds that are finite, then the lower
            ones; -1 if there is no limit.
        piece: Piece of the trajectory.
        fraction: Fraction of the piece.
    """

    value: float
    row: int
    piece: int
    fraction: float


@dataclass(frozen=True)
class JointJumps:
    """Largest sums of consecutive jumps, as `JumpSums` has them.

    Attributes:
        largest: Largest sum between any two instants, by coordinate, shape (nv,).
        last: The jump that completes it, shape (nv,).
    """

    largest: Array
    last: Indices

    def last_jump(self, column: int) -> int:
        """Return the index of the jump that completes the largest sum of a coordinate."""
        return int(self.last[column])


@dataclass(frozen=True)
class JointBounds:
    """Bounds on the joints of one trajectory.

    Attributes:
        forms: Bernstein coefficients by order of derivative, each shape (nv, n, k).
        magnitudes: The largest absolute values in them, shape (orders, nv).
        position: Largest excess over a bound of positions, rounding errors included.
        rates: Peak over limit by order from 1 on, without rounding errors.
        jumps: Sums of jumps of positions, velocities and accelerations; of accelerations those from
            and to rest as well.
    """

    forms: tuple[Array, ...]
    magnitudes: Array
    position: JointPeak
    rates: tuple[JointPeak, ...]
    jumps: tuple[JointJumps, ...]

    @classmethod
    def of(
        cls,
        trajectory: TimedTrajectory,
        group: JointGroup,
        limits: JointLimits,
        rates: tuple[str, ...],
    ) -> "JointBounds | None":
        """Build by the kernel; None if it cannot, or a number is not finite.

        Args:
            trajectory: The motion, with times that increase.
            group: Its group.
            limits: Limits of the group's joints.
            rates: Names of the limited rates, by order from 1 on.
        """
        module = native()
        if module is None or not trajectory.manifold.is_vector_space:
            return None
        is_scalar = all(indices == (i,) for i, (_, indices) in enumerate(group.blocks))
        if not is_scalar or trajectory.coefficients.shape[1] > LOW_DEGREE + 1:
            return None
        curve = trajectory.breaks, trajectory.bases, trajectory.coefficients
        if not isfinite(sum(float(part.sum()) for part in curve)):
            return None
        forms, magnitudes, position, peaks, jumps = module.joint_bounds(
            curve,
            limits.lower,
            limits.upper,
            np.stack([getattr(limits, name) for name in rates]),
            POSITION_GAP,
            RATE_GAP,
        )
        return cls(
            tuple(forms),
            magnitudes,
            JointPeak(*position),
            tuple(JointPeak(*peak) for peak in peaks),
            tuple(JointJumps(*sums) for sums in jumps),
        )
