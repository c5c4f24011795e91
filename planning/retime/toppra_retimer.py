"""Time-optimal profiles under velocity and acceleration limits, by TOPP-RA.

Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
analysis", T-RO 2018. Only the speeds at the grid points are taken from toppra: between them s(t)
has constant acceleration, and q(t) = r(s(t)) is composed exactly, so the motion never leaves the
path.
"""

import logging
import warnings
from typing import Any, override

import numpy as np

from planning.domain.curve import JointSpline
from planning.domain.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.bounds import block_peaks
from planning.retime.compose import shifted
from planning.retime.line_profile import line_profile
from planning.retime.path_rows import acceleration_rows
from planning.retime.profile import SpeedProfile

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from toppra.algorithm import TOPPRA
    from toppra.constraint import ConstraintType, DiscretizationType, LinearConstraint
    from toppra.interpolator import AbstractGeometricPath

logging.getLogger("toppra").setLevel(logging.CRITICAL)

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Grid intervals for a stretch of nothing but curves, or nothing but lines, and for any piece: on
# a line only the instant at which braking begins has to be met.
_ON_CURVES, _ON_LINES, _LEAST_PER_PIECE = 200, 80, 3
# Squared speeds beyond this, in toppra's units of order one, are unbounded to it.
_UNBOUNDED = 1e6


def toppra_profile(stretch: JointSpline, limits: JointLimits) -> SpeedProfile:
    """Return the quickest rest-to-rest profile along a smooth stretch.

    Raises:
        RetimingFailed: toppra finds none.
    """
    rates = block_peaks(stretch, limits, 1)
    if stretch.num_pieces == 1 and not stretch.coefficients[:, 2:].any():
        with np.errstate(divide="ignore"):
            speed = float((limits.velocity / rates).min())
            acceleration = float((limits.acceleration / rates).min())
        begin, end = float(stretch.breaks[0]), float(stretch.breaks[-1])
        return line_profile(begin, end, speed, acceleration)
    grid = _grid(stretch)
    steps = np.diff(grid)
    # In units of the least time that a path as fast as allowed would take, toppra's numbers are
    # of order one, as its absolute tolerances want them.
    unit = float(((rates / limits.velocity).max(axis=1) * np.diff(stretch.breaks)).sum())
    x = _squared_speeds(stretch, limits, grid, unit) / unit**2
    speeds = np.sqrt(x)
    return SpeedProfile(
        grid,
        speeds[:-1],
        np.diff(x) / (2 * steps),
        np.zeros(len(steps)),
        2 * steps / (speeds[:-1] + speeds[1:]),
    )


def _squared_speeds(stretch: JointSpline, limits: JointLimits, grid: Array, unit: float) -> Array:
    """Return toppra's (ds/dt)^2 at the grid points, with time in `unit` seconds."""
    bounds = _Bounds(stretch, limits, unit)
    solver = TOPPRA([bounds], _Path(stretch), gridpoints=grid, solver_wrapper="seidel")
    speeds = solver.compute_parameterization(0.0, 0.0)[1]
    if speeds is None or not np.isfinite(speeds).all():
        message = "toppra finds no speed profile along the path"
        raise RetimingFailed(message, {"method": "toppra", "num_grid_points": len(grid)})
    x = np.asarray(speeds, dtype=np.float64).ravel() ** 2
    x[[0, -1]] = 0.0
    if not (x[:-1] + x[1:] > 0).all():
        message = "toppra's profile stands still on the way"
        raise RetimingFailed(message, {"method": "toppra", "num_grid_points": len(grid)})
    return x


def _grid(stretch: JointSpline) -> Array:
    """Return grid points, evenly spaced on each piece, with every break among them."""
    widths = np.diff(stretch.breaks)
    is_curved = stretch.coefficients[:, 2:].any(axis=(1, 2))
    wanted = np.where(is_curved, _ON_CURVES, _ON_LINES)
    counts = np.ceil(wanted * widths / widths.sum()).astype(int)
    parts = [
        np.linspace(a, b, max(_LEAST_PER_PIECE, count) + 1)[:-1]
        for a, b, count in zip(stretch.breaks[:-1], stretch.breaks[1:], counts, strict=True)
    ]
    return np.append(np.concatenate(parts), stretch.breaks[-1])


class _Path(AbstractGeometricPath):
    """The stretch as toppra sees it; only its extent matters, `_Bounds` reads the rest."""

    def __init__(self, stretch: JointSpline) -> None:
        self._stretch = stretch

    @override
    def __call__(self, path_positions: Any, order: int = 0) -> Any:
        return self._stretch.tangents(np.atleast_1d(path_positions), order)

    @property
    @override
    def dof(self) -> int:
        return self._stretch.coefficients.shape[2]

    @property
    @override
    def path_interval(self) -> Array:
        return self._stretch.breaks[[0, -1]]

    @property
    @override
    def waypoints(self) -> Any:
        return self._stretch.breaks, self._stretch.positions(self._stretch.breaks)


class _Bounds(LinearConstraint):
    """Velocity and acceleration limits on every grid interval, from that interval's own piece.

    toppra's own constraints look at grid points only and take one side's r'' where it jumps.
    Velocity bounds x = sdot^2 at both ends of an interval by the largest |r'| in between.
    """

    def __init__(self, stretch: JointSpline, limits: JointLimits, unit: float) -> None:
        super().__init__()
        self.constraint_type = ConstraintType.CanonicalLinear
        self.discretization_type = DiscretizationType.Collocation
        self.identical = True
        self.dof = stretch.coefficients.shape[2]
        self._stretch = stretch
        self._limits = limits
        self._unit = unit

    @override
    def compute_constraint_params(
        self, path: Any, gridpoints: Array, *args: Any, **kwargs: Any
    ) -> tuple[Any, ...]:
        a, b = acceleration_rows(self._stretch, self._limits, gridpoints)
        a, b = a / self._unit**2, b / self._unit**2
        # Nothing follows the last grid point; toppra wants rows for it all the same.
        a, b = np.vstack([a, a[-1:]]), np.vstack([b, b[-1:]])
        count = a.shape[1]
        bounds = np.ones(count)
        return a, b, np.zeros_like(a), np.eye(count), bounds, None, self._speed_bounds(gridpoints)

    def _speed_bounds(self, grid: Array) -> Array:
        """Return bounds on x at the grid points that keep the speed in between as well."""
        pieces, _ = self._stretch.locate((grid[:-1] + grid[1:]) / 2)
        peaks = block_peaks(_cut(self._stretch, grid, pieces), self._limits, 1)
        with np.errstate(divide="ignore"):
            fastest = self._unit * (self._limits.velocity / peaks).min(axis=1)
        x = np.minimum(np.append(fastest, np.inf), np.insert(fastest, 0, np.inf)) ** 2
        return np.stack([np.zeros_like(x), np.minimum(x, _UNBOUNDED)], axis=1)


def _cut(stretch: JointSpline, grid: Array, pieces: Any) -> JointSpline:
    """Return the stretch with a piece for every grid interval."""
    local = shifted(stretch.coefficients[pieces], grid[:-1] - stretch.breaks[pieces])
    return JointSpline(stretch.joints, grid, stretch.bases[pieces], local)
