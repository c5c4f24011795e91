"""ZoneSpeed: a limit on the speed of a frame's origin inside a box (speed zone)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.geometry import rotation
from planning.domain.request.motion_limits import SpeedZone
from planning.kernel.native import native
from planning.retime.block_peaks import bernstein_block_norms, block_peaks
from planning.retime.compose import taylor_shifted
from planning.retime.jerk.velocity_bounds import cell_velocity_bounds
from planning.retime.limit_utilization import max_utilization
from planning.retime.limits.path_limit import HEADROOM, PathUtilization
from planning.retime.limits.tool_path import ToolPath
from planning.retime.limits.tool_rate import point_limits
from planning.retime.polynomials import halved, norms, to_bernstein

# Distance before the box at which motions are slow already, so that a proof can separate the box
# from its outside [m].
_APPROACH_DISTANCE = 1e-4
# Shares of that distance by which the box is enlarged: for cutting cells, for bounding their
# speeds, and for the audit. They decrease so that a cell that ends at the box is not taken to be in
# it.
_CUT_SHARE, _BOUND_SHARE, _AUDIT_SHARE = 1.0, 0.75, 0.5
# Number of halvings of parts that may be partly in a box.
_NUM_BISECTIONS = 14


@dataclass(frozen=True)
class ZoneSpeed:
    """Largest speed of a frame's origin inside a box.

    Attributes:
        zone: The box in world.
        path: Path of the frame.
        speed: Speed limit [m/s].
    """

    zone: SpeedZone
    path: ToolPath
    speed: float

    @property
    def name(self) -> str:
        """Kind of limit, as in certificates."""
        return "speed_zone"

    @property
    def is_uniform(self) -> bool:
        """False: a line may lead into the box."""
        return False

    def discontinuities(self, smooth_piece: JointSpline) -> Array:
        """Return the parameters at which the origin enters and leaves the box."""
        visits = _visits(self.zone, self.path.along(smooth_piece), _CUT_SHARE * _APPROACH_DISTANCE)
        edges, counts = np.unique(np.concatenate([visits.low, visits.high]), return_counts=True)
        return edges[counts == 1]

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return no rows."""
        no_rows = np.zeros((cells.num_pieces, 0))
        return no_rows, no_rows

    def path_velocity_bounds(self, cells: JointSpline) -> Array:
        """Return the bounds on x of cells that are at least partly in the box."""
        along, limits = self.path.along(cells), point_limits(self.speed / (1 + HEADROOM))
        bounds = cell_velocity_bounds(bernstein_block_norms(along, limits, 1), limits.velocity)
        return np.where(self._are_in_box(along)[:, None], bounds, np.inf)

    def peaks(self, cells: JointSpline) -> Array:
        """Return the largest first derivative over the limit on the cells that are in the box."""
        along, limits = self.path.along(cells), point_limits(self.speed / (1 + HEADROOM))
        cell_peaks = np.zeros((6, cells.num_pieces, 1))
        peaks = block_peaks(along, limits, 1) / limits.velocity
        cell_peaks[0] = np.where(self._are_in_box(along)[:, None], peaks, 0.0)
        return cell_peaks

    def _are_in_box(self, along: JointSpline) -> Any:
        """Return whether each piece is at least partly in the box."""
        is_in = np.zeros(along.num_pieces, dtype=bool)
        is_in[_visits(self.zone, along, _BOUND_SHARE * _APPROACH_DISTANCE).pieces] = True
        return is_in

    def utilizations(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the largest speed over the limit on all parts that may be in the box."""
        along = self.path.along(trajectory)
        visits = _visits(self.zone, along, _AUDIT_SHARE * _APPROACH_DISTANCE)
        if not len(visits.low):
            return ()
        utilization = max_utilization(visits.of(along), point_limits(self.speed), 1)
        return (PathUtilization.of_rate(self.zone.name, utilization.fraction, 1),)

    def sampled_utilization(self, curve: Curve, times: Array) -> Mapping[str, Array]:
        """Return the speed over the limit, zero outside."""
        along = self.path.along(curve)
        local = np.abs(_in_box(self.zone, along.positions(times)))
        is_in = (local <= self.zone.box.size / 2 + _APPROACH_DISTANCE).all(axis=1)
        return {self.zone.name: np.where(is_in, norms(along.tangents(times, 1)) / self.speed, 0.0)}

    def relaxed(self, where: str, factor: float) -> "ZoneSpeed":
        """Return the limit multiplied by a factor, if it is this zone's."""
        return replace(self, speed=self.speed * factor) if where == self.zone.name else self


@dataclass(frozen=True)
class Visits:
    """Parts of pieces, in order, that contain all visits of a point to a box.

    Attributes:
        pieces: Index of the piece of each part, shape (n,).
        low: Beginning of each part, in the curve's parameter.
        high: End of each part.
    """

    pieces: Any
    low: Array
    high: Array

    def of(self, curve: JointSpline) -> JointSpline:
        """Return these parts of the curve joined, with a parameter of their own."""
        local = taylor_shifted(
            curve.coefficients[self.pieces], self.low - curve.breaks[self.pieces]
        )
        breaks = np.append(0.0, np.cumsum(self.high - self.low))
        return JointSpline(curve.joints, breaks, curve.bases[self.pieces], local)


def _visits(zone: SpeedZone, curve: JointSpline, padding: float) -> Visits:
    """Return the parts of a curve on which a point may be within `padding` of a box [m].

    By Bernstein coefficients in the box's axes: if all are beyond a face, so is the curve.
    """
    half = zone.box.size / 2 + padding
    polynomials = to_bernstein(curve.coefficients, np.diff(curve.breaks)) + curve.bases[:, None]
    polynomials = _in_box(zone, polynomials)
    module = native()
    if module is None:
        return visits_in_numpy(curve.breaks, polynomials, half)
    # The kernel takes finite numbers; no point is farther than the largest one.
    half = np.minimum(half, np.finfo(np.float64).max)
    return Visits(*module.box_visits(curve.breaks, polynomials, half, _NUM_BISECTIONS))


def visits_in_numpy(breaks: Array, polynomials: Array, half: Array) -> Visits:
    """Return the parts on which a point may be in a box, without the kernel.

    Args:
        breaks: Of the curve, shape (n + 1,).
        polynomials: Bernstein coefficients in the box's axes, relative to its centre [m], shape
            (n, k, 3).
        half: Half the size of the box [m], shape (3,).
    """
    pieces = np.arange(len(polynomials))
    low, high = breaks[:-1], breaks[1:]
    found: list[tuple[Any, Array, Array]] = []
    for depth in range(_NUM_BISECTIONS + 1):
        is_outside = ((polynomials > half).all(axis=1) | (polynomials < -half).all(axis=1)).any(
            axis=1
        )
        is_done = (np.abs(polynomials) <= half).all(axis=(1, 2)) | (depth == _NUM_BISECTIONS)
        done, is_open = ~is_outside & is_done, ~is_outside & ~is_done
        found.append((pieces[done], low[done], high[done]))
        if not is_open.any():
            break
        polynomials, pieces = halved(polynomials[is_open]), np.repeat(pieces[is_open], 2)
        middle = (low[is_open] + high[is_open]) / 2
        low = np.stack([low[is_open], middle], axis=1).ravel()
        high = np.stack([middle, high[is_open]], axis=1).ravel()
    pieces, low, high = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.argsort(low)
    return Visits(pieces[order], low[order], high[order])


def _in_box(zone: SpeedZone, points: Array) -> Array:
    """Return points in the box's axes, relative to its centre."""
    pose = zone.box.pose
    return (points - pose.position) @ rotation.matrix(pose.quaternion)
