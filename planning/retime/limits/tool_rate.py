"""ToolRate: a limit on the speed or the acceleration of a frame's origin.

For the retimer the origin's path is one more curve whose three coordinates have a common limit, as
those of a floating body have: the same rows, bounds and audit as for joints.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.retime.block_peaks import bernstein_block_norms, block_peaks
from planning.retime.jerk.velocity_bounds import cell_velocity_bounds
from planning.retime.limit_utilization import max_utilization
from planning.retime.limits.path_limit import HEADROOM, PathUtilization
from planning.retime.limits.tool_path import ToolPath
from planning.retime.polynomials import norms
from planning.retime.toppra.path_rows import acceleration_rows


@dataclass(frozen=True)
class ToolRate:
    """Largest speed (order 1) or acceleration (order 2) of a frame's origin.

    Attributes:
        frame: Full name of the frame.
        path: Path of the frame.
        order: Order of the derivative.
        limit: Largest value [m/s or m/s^2].
    """

    frame: str
    path: ToolPath
    order: int
    limit: float

    @property
    def name(self) -> str:
        """Kind of limit, as in certificates."""
        return "tool_speed" if self.order == 1 else "tool_acceleration"

    @property
    def is_uniform(self) -> bool:
        """False: the tool's rate varies along a line in joint space."""
        return False

    def discontinuities(self, smooth_piece: JointSpline) -> Array:  # noqa: ARG002
        """Return no cuts."""
        return np.zeros(0)

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return the rows of an acceleration limit; none for a speed limit."""
        if self.order == 1:
            no_rows = np.zeros((cells.num_pieces, 0))
            return no_rows, no_rows
        return acceleration_rows(self.path.along(cells), self._limits)

    def path_velocity_bounds(self, cells: JointSpline) -> Array:
        """Return the bounds on x of a speed limit; none for an acceleration limit."""
        if self.order == 2:
            return np.full((cells.num_pieces, 2), np.inf)
        limits = self._limits
        return cell_velocity_bounds(
            bernstein_block_norms(self.path.along(cells), limits, 1), limits.velocity
        )

    def peaks(self, cells: JointSpline) -> Array:
        """Return the largest first derivative over the limit, and second if that is limited."""
        limits = self._limits
        cell_peaks = np.zeros((6, cells.num_pieces, 1))
        along = self.path.along(cells)
        cell_peaks[self.order - 1] = block_peaks(along, limits, 1) / limits.velocity
        if self.order == 2:
            cell_peaks[3] = block_peaks(along, limits, 2) / limits.acceleration
        return cell_peaks

    def utilizations(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the largest rate over the limit, by branch and bound."""
        limits = point_limits(self.limit)
        utilization = max_utilization(self.path.along(trajectory), limits, self.order)
        return (PathUtilization.of_rate(self.frame, utilization.fraction, self.order),)

    def sampled_utilization(self, curve: Curve, times: Array) -> Mapping[str, Array]:
        """Return the rate over the limit at instants."""
        return {self.frame: norms(self.path.along(curve).tangents(times, self.order)) / self.limit}

    def relaxed(self, where: str, factor: float) -> "ToolRate":
        """Return the limit multiplied by a factor, if it is this frame's."""
        return replace(self, limit=self.limit * factor) if where == self.frame else self

    @property
    def _limits(self) -> JointLimits:
        return point_limits(self.limit / (1 + HEADROOM))


def point_limits(rate: float) -> JointLimits:
    """Return limits of a point in space, with all three coordinates in one block."""
    free, one = np.full(3, np.inf), np.array([rate])
    return JointLimits(-free, free, one, one, one, one, ((0, 1, 2),))
