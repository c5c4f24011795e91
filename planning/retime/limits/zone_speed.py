"""ZoneSpeed: a limit on the speed of a frame's origin while it is in a box."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.domain.curves.curve import Curve, JointSpline, TimedTrajectory
from planning.domain.geometry import rotation
from planning.domain.request.motion_limits import SpeedZone
from planning.retime.bounds import block_peaks, block_sizes
from planning.retime.compose import shifted
from planning.retime.jerk.velocity_bounds import speed_caps
from planning.retime.limit_utilization import largest_use
from planning.retime.limits.path_limit import HEADROOM, PathUtilization
from planning.retime.limits.tool_path import ToolPath
from planning.retime.limits.tool_rate import together
from planning.retime.polynomials import halved, norms, to_bernstein

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Motions are slow this far before the box already, so that a proof can tell before from in [m].
_BEFORE = 1e-4
# What may be in the box is looked at from the nearest first: where cells are cut, which of them are
# capped, and what is audited, each with some less of that distance than the one before, so that a
# cell that ends at the box is not taken to be in it.
_CUT, _CAPPED, _AUDITED = 1.0, 0.75, 0.5
# Parts that may be partly in a box are halved so often.
_HALVINGS = 14


@dataclass(frozen=True)
class ZoneSpeed:
    """At most so much speed in a box.

    Attributes:
        zone: The box in world.
        path: Of the frame.
        speed: [m/s].
    """

    zone: SpeedZone
    path: ToolPath
    speed: float

    @property
    def name(self) -> str:
        """As certificates have it."""
        return "speed_zone"

    @property
    def is_uniform(self) -> bool:
        """No: a line may lead into the box."""
        return False

    def cuts(self, stretch: JointSpline) -> Array:
        """Return where the origin enters and leaves."""
        visits = _visits(self.zone, self.path.along(stretch), _CUT * _BEFORE)
        edges, counts = np.unique(np.concatenate([visits.low, visits.high]), return_counts=True)
        return edges[counts == 1]

    def rows(self, cells: JointSpline) -> tuple[Array, Array]:
        """Return none."""
        nothing = np.zeros((cells.num_pieces, 0))
        return nothing, nothing

    def caps(self, cells: JointSpline) -> Array:
        """Return the caps on the cells that are in the box, if only partly."""
        along, limits = self.path.along(cells), together(self.speed / (1 + HEADROOM))
        caps = speed_caps(block_sizes(along, limits, 1), limits.velocity)
        return np.where(self._are_in(along)[:, None], caps, np.inf)

    def peaks(self, cells: JointSpline) -> Array:
        """Return the largest first derivative over the limit on the cells that are in the box."""
        along, limits = self.path.along(cells), together(self.speed / (1 + HEADROOM))
        found = np.zeros((6, cells.num_pieces, 1))
        peaks = block_peaks(along, limits, 1) / limits.velocity
        found[0] = np.where(self._are_in(along)[:, None], peaks, 0.0)
        return found

    def _are_in(self, along: JointSpline) -> Any:
        """Return whether each piece is in the box, if only partly."""
        is_in = np.zeros(along.num_pieces, dtype=bool)
        is_in[_visits(self.zone, along, _CAPPED * _BEFORE).pieces] = True
        return is_in

    def uses(self, trajectory: TimedTrajectory) -> tuple[PathUtilization, ...]:
        """Return the largest speed over the limit on all that may be in the box."""
        along = self.path.along(trajectory)
        visits = _visits(self.zone, along, _AUDITED * _BEFORE)
        if not len(visits.low):
            return ()
        use = largest_use(visits.of(along), together(self.speed), 1)
        return (PathUtilization.of_rate(self.zone.name, use.fraction, 1),)

    def shares(self, curve: Curve, times: Array) -> Mapping[str, Array]:
        """Return the speed over the limit, zero outside."""
        along = self.path.along(curve)
        local = np.abs(_in_box(self.zone, along.positions(times)))
        is_in = (local <= self.zone.box.size / 2 + _BEFORE).all(axis=1)
        return {self.zone.name: np.where(is_in, norms(along.tangents(times, 1)) / self.speed, 0.0)}

    def relaxed(self, where: str, factor: float) -> "ZoneSpeed":
        """Return the limit times a factor, if it is this zone's."""
        return replace(self, speed=self.speed * factor) if where == self.zone.name else self


@dataclass(frozen=True)
class _Visits:
    """Parts of pieces, in order, outside of which a point is outside a box.

    Attributes:
        pieces: Whose parts, shape (n,).
        low: Where each begins, in the curve's parameter.
        high: Where it ends.
    """

    pieces: Any
    low: Array
    high: Array

    def of(self, curve: JointSpline) -> JointSpline:
        """Return these parts of the curve put together, with a parameter of their own."""
        local = shifted(curve.coefficients[self.pieces], self.low - curve.breaks[self.pieces])
        breaks = np.append(0.0, np.cumsum(self.high - self.low))
        return JointSpline(curve.joints, breaks, curve.bases[self.pieces], local)


def _visits(zone: SpeedZone, curve: JointSpline, before: float) -> _Visits:
    """Return when a point that moves along a curve may be in a box, or this far before it [m].

    By Bernstein coefficients in the box's axes: all of them beyond a face, and so is the curve.
    """
    half = zone.box.size / 2 + before
    pieces = np.arange(curve.num_pieces)
    low, high = curve.breaks[:-1], curve.breaks[1:]
    forms = to_bernstein(curve.coefficients, np.diff(curve.breaks)) + curve.bases[:, None]
    forms = _in_box(zone, forms)
    found: list[tuple[Any, Array, Array]] = []
    for depth in range(_HALVINGS + 1):
        is_outside = ((forms > half).all(axis=1) | (forms < -half).all(axis=1)).any(axis=1)
        is_done = (np.abs(forms) <= half).all(axis=(1, 2)) | (depth == _HALVINGS)
        done, left = ~is_outside & is_done, ~is_outside & ~is_done
        found.append((pieces[done], low[done], high[done]))
        forms, pieces = halved(forms[left]), np.repeat(pieces[left], 2)
        middle = (low[left] + high[left]) / 2
        low = np.stack([low[left], middle], axis=1).ravel()
        high = np.stack([middle, high[left]], axis=1).ravel()
    pieces, low, high = (np.concatenate(parts) for parts in zip(*found, strict=True))
    order = np.argsort(low)
    return _Visits(pieces[order], low[order], high[order])


def _in_box(zone: SpeedZone, points: Array) -> Array:
    """Return points in the box's axes, from its middle."""
    pose = zone.box.pose
    return (points - pose.position) @ rotation.matrix(pose.quaternion)
