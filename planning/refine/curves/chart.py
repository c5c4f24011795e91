"""Charts: coordinates in R^n of the configurations along a path, for the optimiser.

Control points are in these coordinates. Where joints do not float, positions are their own
coordinates, without jumps by full turns. Else they are tangents at one configuration in the middle
of the path, q = base [+] delta, in which |delta'| bounds every rate (`domain/curves/curve.py`).

The shortest tangents jump where a rotation is half a turn from the base, but they need not be the
shortest: delta is continued along the path, and q(delta) is smooth and regular as long as delta is
shorter than a full turn. The longer it is, the more |delta'| exceeds the rate across it, by theta /
(2 sin(theta / 2)): so the base is chosen where the longest tangent is short.
"""

from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.manifold import Manifold
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.curves.bspline_basis import spline_of
from planning.refine.curves.fit import unwrapped
from planning.refine.curves.power_basis import joint_spline
from planning.refine.curves.unwrapped_tangents import tangents_along, turns_of

# Longest tangent up to which the middle configuration serves as the base [rad].
_LONG = 2.2
# Longest tangent for a chart: beyond, rates across it are overestimated by a factor of three [rad].
_LONGEST = 4.5
# Number of bases that are tried.
_MOST_BASES = 33
# Step along geodesics between waypoints, which are no straight lines in a chart.
_APART = 0.05


@runtime_checkable
class Chart(Protocol):
    """Coordinates of configurations along one path.

    Attributes:
        waypoints: Of the path, no two consecutive ones the same, shape (n, nv).
    """

    @property
    def waypoints(self) -> Array:
        """Waypoints of the path in these coordinates, shape (n, nv)."""
        ...

    @property
    def winds(self) -> bool:
        """Whether the path turns so far that the shortest path between its ends is another one."""
        ...

    def positions(self, deltas: Float64[np.ndarray, "m nv"]) -> Float64[np.ndarray, "m nq"]:
        """Return the configurations with given coordinates."""
        ...

    def box(self, limits: JointLimits) -> JointLimits:
        """Return limits with position bounds in these coordinates."""
        ...

    def measured(self, nearness: DistanceQuery) -> DistanceQuery:
        """Return a distance query in these coordinates, gradients included."""
        ...

    def curve(self, points: Float64[np.ndarray, "k nv"]) -> JointSpline:
        """Return the curve with these control points."""
        ...


@dataclass(frozen=True)
class FlatChart:
    """Positions themselves as coordinates, for joints that do not float."""

    path: JointPath

    @property
    def waypoints(self) -> Array:
        """Waypoints of the path, without jumps by full turns."""
        return unwrapped(self.path)

    @property
    def winds(self) -> bool:
        """False: angles keep the direction that the search has chosen."""
        return False

    def positions(self, deltas: Float64[np.ndarray, "m nv"]) -> Float64[np.ndarray, "m nq"]:
        """Return the coordinates themselves."""
        return deltas

    def box(self, limits: JointLimits) -> JointLimits:
        """Return the same limits."""
        return limits

    def measured(self, nearness: DistanceQuery) -> DistanceQuery:
        """Return the same distance query: v is the derivative of positions."""
        return nearness

    def curve(self, points: Float64[np.ndarray, "k nv"]) -> JointSpline:
        """Return the curve with these control points."""
        return joint_spline(self.path.group.joints, spline_of(points))


@dataclass(frozen=True)
class TangentChart:
    """Tangents at one configuration as coordinates.

    Attributes:
        path: Path that the chart covers.
        base: The configuration, shape (nq,).
        waypoints: Of the path, in small steps.
    """

    path: JointPath
    base: Float64[np.ndarray, " nq"]
    waypoints: Float64[np.ndarray, "n nv"]

    @property
    def winds(self) -> bool:
        """Whether a joint turns farther from the base than half of any shortest path does."""
        return bool(turns_of(self.path.group, self.waypoints).max() > _LONG)

    def positions(self, deltas: Float64[np.ndarray, "m nv"]) -> Float64[np.ndarray, "m nq"]:
        """Return base [+] delta."""
        return self._manifold.plus(self.base, deltas)

    def box(self, limits: JointLimits) -> JointLimits:
        """Return position limits relative to the base; rotations have none."""
        group = self.path.group
        names = group.velocity_names
        shared = [name for name in group.position_names if name in names]
        in_q = [group.position_names.index(name) for name in shared]
        in_v = [names.index(name) for name in shared]
        lower, upper = np.full(len(names), -np.inf), np.full(len(names), np.inf)
        lower[in_v] = limits.lower[in_q] - self.base[in_q]
        upper[in_v] = limits.upper[in_q] - self.base[in_q]
        return replace(limits, lower=lower, upper=upper)

    def measured(self, nearness: DistanceQuery) -> DistanceQuery:
        """Return a distance query with gradients with respect to delta."""
        return _TangentNearness(nearness, self)

    def rates(self, deltas: Float64[np.ndarray, "m nv"]) -> Float64[np.ndarray, "m nv nv"]:
        """Return Drake's v per unit rate of each coordinate, along the last axis."""
        q = self.positions(deltas)
        units = np.eye(deltas.shape[1])
        columns = [
            self._manifold.generalized_velocity(q, deltas, np.broadcast_to(unit, deltas.shape))
            for unit in units
        ]
        return np.stack(columns, axis=2)

    def curve(self, points: Float64[np.ndarray, "k nv"]) -> JointSpline:
        """Return the curve with these control points."""
        flat = joint_spline(self.path.group.joints, spline_of(points))
        coefficients = flat.coefficients.copy()
        coefficients[:, 0] += flat.bases
        bases = np.broadcast_to(self.base, (flat.num_pieces, len(self.base)))
        return JointSpline(self.path.group.joints, flat.breaks, bases, coefficients)

    @property
    def _manifold(self) -> Manifold:
        return Manifold(self.path.group.joints)


@dataclass(frozen=True)
class _TangentNearness:
    inner: DistanceQuery
    chart: TangentChart

    def within(self, qs: Float64[np.ndarray, "m nv"], reach: float) -> DistanceRows:
        """Return the pairs with a signed margin below `reach` [m]."""
        near = self.inner.within(self.chart.positions(qs), reach)
        rates = self.chart.rates(qs)[near.at]
        return DistanceRows(near.at, near.spare, np.einsum("mi,mij->mj", near.gradient, rates))


def chart_of(path: JointPath) -> FlatChart | TangentChart:
    """Return the chart of a path.

    If the path turns too far for one tangent space, it is the chart of the straight path between
    its ends instead.
    """
    manifold = Manifold(path.group.joints)
    if manifold.is_flat:
        return FlatChart(path)
    dense = _dense(path)
    middle = np.array([len(dense) // 2])
    base, deltas, longest = _charted(path, dense, middle)
    if longest > _LONG:
        tried = np.linspace(0, len(dense) - 1, _MOST_BASES).astype(np.intp)
        base, deltas, longest = _charted(path, dense, tried)
    if longest > _LONGEST:
        return chart_of(path.straight)
    moves = np.linalg.norm(np.diff(deltas, axis=0), axis=1) > 1e-9
    return TangentChart(path, base, deltas[np.concatenate([[True], moves])])


def _dense(path: JointPath) -> Array:
    """Return configurations along a path, in small steps."""
    count = max(2, int(path.length / _APART) + 1)
    return path.spline.positions(np.linspace(0.0, 1.0, count))


def _charted(path: JointPath, dense: Array, anchors: Any) -> tuple[Array, Array, float]:
    """Return the best of several bases, the tangents there, and their longest turn [rad]."""
    tangents = tangents_along(path.group, dense, anchors)
    turns = turns_of(path.group, tangents).max(axis=(0, 2))
    best = int(turns.argmin())
    return dense[anchors[best]], tangents[:, best], float(turns[best])
