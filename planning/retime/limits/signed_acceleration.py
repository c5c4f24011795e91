"""SignedAcceleration: acceleration limits that differ for speeding up and slowing down."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory, derivative
from planning.domain.request.motion_limits import AccelerationBounds
from planning.retime.limit_utilization import largest_value
from planning.retime.limits.path_limit import PathUtilization
from planning.retime.polynomials import to_bernstein
from planning.retime.toppra.path_rows import CellPlaces


@dataclass(frozen=True)
class SignedAcceleration:
    """Lowest and highest accelerations of scalar blocks.

    Attributes:
        bounds: Lowest and highest acceleration by name of the block [rad/s^2 or m/s^2].
        columns: Indices of the blocks in v, in the same order.
    """

    bounds: AccelerationBounds
    columns: tuple[int, ...]

    @property
    def name(self) -> str:
        """Kind of limit, as in the options."""
        return "acceleration_bounds"

    @property
    def is_uniform(self) -> bool:
        """True: along a line in joint space every joint's acceleration is a multiple of u."""
        return True

    def cuts(self, stretch: JointSpline) -> Array:  # noqa: ARG002
        """Return no cuts."""
        return np.zeros(0)

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return two rows for every block and place."""
        places = CellPlaces.of(cells)
        ahead, bend = (self._shares(part) for part in places.derivatives)
        return places.by_cell(ahead, bend)

    def caps(self, cells: JointSpline) -> Array:
        """Return no bounds."""
        return np.full((cells.num_pieces, 2), np.inf)

    def peaks(self, cells: JointSpline) -> Array:
        """Return the largest derivatives over the smaller of both bounds, regardless of sign."""
        found = np.zeros((6, cells.num_pieces, len(self.columns)))
        widths = np.diff(cells.breaks)
        for row, order in ((1, 1), (3, 2)):
            forms = to_bernstein(self._shares(derivative(cells.coefficients, order)), widths)
            sizes = np.abs(forms).max(axis=1)
            found[row] = sizes.reshape(cells.num_pieces, -1, 2).max(axis=2)
        return found

    def uses(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the largest acceleration over its bound, by branch and bound."""
        changes = derivative(trajectory.coefficients, 2)
        forms = to_bernstein(self._shares(changes), np.diff(trajectory.breaks))
        use = largest_value(forms)
        return (
            PathUtilization.of_rate(self._names[use.block // 2], use.fraction, 2, headroom=0.0),
        )

    def shares(self, curve: Curve, times: Array) -> Mapping[str, Array]:
        """Return acceleration over the bound of its sign, by block."""
        shares = self._shares(curve.tangents(times, 2))
        pairs = shares.reshape(len(times), -1, 2).max(axis=2)
        return dict(zip(self._names, pairs.T, strict=True))

    def relaxed(self, where: str, factor: float) -> "SignedAcceleration":
        """Return the limit with both bounds of a block multiplied by a factor."""
        more = {
            name: (factor * low, factor * high) if name == where else (low, high)
            for name, (low, high) in self.bounds.items()
        }
        return replace(self, bounds=more)

    @property
    def _names(self) -> list[str]:
        return list(self.bounds)

    def _shares(self, rates: Array) -> Array:
        """Return each block's rate over its highest and over its lowest, along the last axis."""
        limits = np.array([[high, low] for low, high in self.bounds.values()])
        shares = rates[..., list(self.columns), None] / limits
        return shares.reshape(*rates.shape[:-1], -1)
