"""SignedAcceleration: acceleration limits that differ for speeding up and slowing down."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory, derivative
from planning.domain.request.motion_limits import AccelerationBounds
from planning.retime.limit_utilization import max_polynomial_value
from planning.retime.limits.path_limit import PathUtilization
from planning.retime.polynomials import to_bernstein
from planning.retime.toppra.path_rows import CellSamples


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

    def discontinuities(self, smooth_piece: JointSpline) -> Array:  # noqa: ARG002
        """Return no cuts."""
        return np.zeros(0)

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return two rows for every block and sample."""
        samples = CellSamples.of(cells)
        a, b = (self._bound_ratios(part) for part in samples.derivatives)
        return samples.rows_by_cell(a, b)

    def path_velocity_bounds(self, cells: JointSpline) -> Array:
        """Return no bounds."""
        return np.full((cells.num_pieces, 2), np.inf)

    def peaks(self, cells: JointSpline) -> Array:
        """Return the largest derivatives over the smaller of both bounds, regardless of sign."""
        cell_peaks = np.zeros((6, cells.num_pieces, len(self.columns)))
        widths = np.diff(cells.breaks)
        for row, order in ((1, 1), (3, 2)):
            polynomials = to_bernstein(
                self._bound_ratios(derivative(cells.coefficients, order)), widths
            )
            sizes = np.abs(polynomials).max(axis=1)
            cell_peaks[row] = sizes.reshape(cells.num_pieces, -1, 2).max(axis=2)
        return cell_peaks

    def utilizations(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the largest acceleration over its bound, by branch and bound."""
        accelerations = derivative(trajectory.coefficients, 2)
        polynomials = to_bernstein(self._bound_ratios(accelerations), np.diff(trajectory.breaks))
        utilization = max_polynomial_value(polynomials)
        return (
            PathUtilization.of_rate(
                self._names[utilization.block // 2], utilization.fraction, 2, headroom=0.0
            ),
        )

    def sampled_utilization(self, curve: Curve, times: Array) -> Mapping[str, Array]:
        """Return acceleration over the bound of its sign, by block."""
        fractions = self._bound_ratios(curve.tangents(times, 2))
        pairs = fractions.reshape(len(times), -1, 2).max(axis=2)
        return dict(zip(self._names, pairs.T, strict=True))

    def relaxed(self, where: str, factor: float) -> "SignedAcceleration":
        """Return the limit with both bounds of a block multiplied by a factor."""
        bounds = {
            name: (factor * low, factor * high) if name == where else (low, high)
            for name, (low, high) in self.bounds.items()
        }
        return replace(self, bounds=bounds)

    @property
    def _names(self) -> list[str]:
        return list(self.bounds)

    def _bound_ratios(self, rates: Array) -> Array:
        """Return each block's rate over its highest and over its lowest, along the last axis."""
        limits = np.array([[high, low] for low, high in self.bounds.values()])
        ratios = rates[..., list(self.columns), None] / limits
        return ratios.reshape(*rates.shape[:-1], -1)
