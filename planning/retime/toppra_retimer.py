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

from planning.domain.curve import JointSpline, derivative
from planning.domain.joints import JointLimits
from planning.errors import RetimingFailed
from planning.retime.bounds import block_peaks
from planning.retime.compose import shifted
from planning.retime.line_profile import line_profile
from planning.retime.profile import SpeedProfile

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from toppra.algorithm import TOPPRA
    from toppra.constraint import (
        ConstraintType,
        DiscretizationType,
        LinearConstraint,
    )
    from toppra.interpolator import AbstractGeometricPath

logging.getLogger("toppra").setLevel(logging.CRITICAL)

type Array = np.ndarray[Any, np.dtype[np.float64]]

_GRID_INTERVALS = 100
_LEAST_PER_PIECE = 3
# Where in each grid interval the acceleration limits are demanded: its ends and its middle.
_PLACES = (0.0, 0.5, 1.0)


def toppra_profile(stretch: JointSpline, limits: JointLimits) -> SpeedProfile:
    """Return the quickest rest-to-rest profile along a smooth stretch.

    Raises:
        RetimingFailed: toppra finds none.
    """
    if stretch.num_pieces == 1 and stretch.coefficients.shape[1] == 2:
        rates = block_peaks(stretch, limits, 1)[0]
        moving = rates > 0
        speed = float((limits.velocity[moving] / rates[moving]).min())
        acceleration = float((limits.acceleration[moving] / rates[moving]).min())
        begin, end = float(stretch.breaks[0]), float(stretch.breaks[-1])
        return line_profile(begin, end, speed, acceleration)
    return _on_grid(stretch, limits)


def _on_grid(stretch: JointSpline, limits: JointLimits) -> SpeedProfile:
    grid = _grid(stretch)
    path = _Path(stretch)
    bounds = _Bounds(stretch, limits)
    solver = TOPPRA([bounds], path, gridpoints=grid, solver_wrapper="seidel")
    solved = solver.compute_parameterization(0.0, 0.0, return_data=True)
    speeds = solved[1]
    if speeds is None or not np.isfinite(speeds).all():
        message = "toppra finds no speed profile along the path"
        raise RetimingFailed(message, {"method": "toppra", "num_grid_points": len(grid)})
    x = np.asarray(speeds, dtype=np.float64).ravel() ** 2
    steps = np.diff(grid)
    sums = np.sqrt(x[:-1]) + np.sqrt(x[1:])
    if not (sums > 0).all():
        message = "toppra's profile stands still on the way"
        raise RetimingFailed(message, {"method": "toppra", "num_grid_points": len(grid)})
    return SpeedProfile(
        grid, np.sqrt(x[:-1]), np.diff(x) / (2 * steps), np.zeros(len(steps)), 2 * steps / sums
    )


def _grid(stretch: JointSpline) -> Array:
    """Return grid points with every break among them, finer towards the resting ends.

    Near rest the profile is s ~ t^2, so equal steps in s are ever longer steps in time.
    """
    total = stretch.breaks[-1] - stretch.breaks[0]
    parts: list[Array] = []
    for a, b in zip(stretch.breaks[:-1], stretch.breaks[1:], strict=True):
        count = max(_LEAST_PER_PIECE, int(np.ceil(_GRID_INTERVALS * (b - a) / total)))
        parts.append(np.linspace(a, b, count + 1)[:-1])
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

    With x = sdot^2 at the interval's beginning and u = sddot constant on it, x + 2 D u holds at a
    distance D into it, where q'' = r' u + r'' (x + 2 D u). Each `_PLACES` gives rows
    a = r' + 2 D r'', b = r''. Velocity bounds x at both ends by the largest |r'| in between.
    """

    def __init__(self, stretch: JointSpline, limits: JointLimits) -> None:
        super().__init__()
        self.constraint_type = ConstraintType.CanonicalLinear
        self.discretization_type = DiscretizationType.Collocation
        self.identical = True
        self.dof = stretch.coefficients.shape[2]
        self._stretch = stretch
        self._limits = limits
        self._acceleration = limits.per_coordinate(limits.acceleration)

    @override
    def compute_constraint_params(
        self, path: Any, gridpoints: Array, *args: Any, **kwargs: Any
    ) -> tuple[Any, ...]:
        steps = np.diff(gridpoints)
        rows_a: list[Array] = []
        rows_b: list[Array] = []
        for place in _PLACES:
            first, second = self._on_intervals(gridpoints, place)
            rows_a.append(first + 2 * place * steps[:, None] * second)
            rows_b.append(second)
        a = np.concatenate(rows_a, axis=1)
        b = np.concatenate(rows_b, axis=1)
        a, b = np.vstack([a, a[-1:]]), np.vstack([b, b[-1:]])
        width = a.shape[1]
        f = np.vstack([np.eye(width), -np.eye(width)])
        g = np.tile(np.tile(self._acceleration, len(_PLACES)), 2)
        return a, b, np.zeros_like(a), f, g, None, self._speed_bounds(gridpoints)

    def _on_intervals(self, grid: Array, place: float) -> tuple[Array, Array]:
        """Return r' and r'' at a fraction of each grid interval, one-sided at breaks."""
        middles = (grid[:-1] + grid[1:]) / 2
        pieces, _ = self._stretch.locate(middles)
        at = grid[:-1] + place * np.diff(grid) - self._stretch.breaks[pieces]
        values: list[Array] = []
        for order in (1, 2):
            coefficients = derivative(self._stretch.coefficients, order)[pieces]
            powers = at[:, None] ** np.arange(coefficients.shape[1])
            values.append(np.einsum("nk,nkv->nv", powers, coefficients))
        return values[0], values[1]

    def _speed_bounds(self, grid: Array) -> Array:
        """Return bounds on x at the grid points that keep the speed in between as well."""
        pieces, _ = self._stretch.locate((grid[:-1] + grid[1:]) / 2)
        peaks = block_peaks(_cut(self._stretch, grid, pieces), self._limits, 1)
        with np.errstate(divide="ignore"):
            fastest = (self._limits.velocity / peaks).min(axis=1)
        x = np.minimum(np.append(fastest, np.inf), np.insert(fastest, 0, np.inf)) ** 2
        return np.stack([np.zeros_like(x), np.minimum(x, 1e12)], axis=1)


def _cut(stretch: JointSpline, grid: Array, pieces: Any) -> JointSpline:
    """Return the stretch with a piece for every grid interval."""
    local = shifted(stretch.coefficients[pieces], grid[:-1] - stretch.breaks[pieces])
    return JointSpline(stretch.joints, grid, stretch.bases[pieces], local)
