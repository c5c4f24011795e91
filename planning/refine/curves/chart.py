"""Charts: coordinates in R^n of the configurations along a path, for the optimizer.

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
from planning.refine.curves.bspline_basis import make_bspline
from planning.refine.curves.bspline_fit import unwrapped_waypoints
from planning.refine.curves.power_basis import joint_spline
from planning.refine.curves.unwrapped_tangents import rotation_angles, tangents_along

# Longest tangent up to which the middle configuration serves as the base [rad].
_MAX_MIDDLE_TANGENT = 2.2
# Longest tangent for a chart: beyond, rates across it are overestimated by a factor of three [rad].
_MAX_TANGENT = 4.5
# Number of bases that are tried.
_MAX_BASES = 33
# Step along geodesics between waypoints, which are no straight lines in a chart.
_SAMPLE_SPACING = 0.05


@runtime_checkable
class Chart(Protocol):
    """Coordinates of configurations along one path.

    Attributes:
        waypoints: Waypoints of the path, no two consecutive ones the same, shape (n, nv).
    """

    @property
    def waypoints(self) -> Array:
        """Waypoints of the path in these coordinates, shape (n, nv)."""
        ...

    @property
    def is_winding(self) -> bool:
        """Whether the path turns so far that the shortest path between its ends is another one."""
        ...

    def positions(self, deltas: Float64[np.ndarray, "m nv"]) -> Float64[np.ndarray, "m nq"]:
        """Return the configurations with given coordinates."""
        ...

    def limits_in_chart(self, limits: JointLimits) -> JointLimits:
        """Return limits with position bounds in these coordinates."""
        ...

    def distance_query_in_chart(self, distance_query: DistanceQuery) -> DistanceQuery:
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
        return unwrapped_waypoints(self.path)

    @property
    def is_winding(self) -> bool:
        """False: angles keep the direction that the search has chosen."""
        return False

    def positions(self, deltas: Float64[np.ndarray, "m nv"]) -> Float64[np.ndarray, "m nq"]:
        """Return the coordinates themselves."""
        return deltas

    def limits_in_chart(self, limits: JointLimits) -> JointLimits:
        """Return the same limits."""
        return limits

    def distance_query_in_chart(self, distance_query: DistanceQuery) -> DistanceQuery:
        """Return the same distance query: v is the derivative of positions."""
        return distance_query

    def curve(self, points: Float64[np.ndarray, "k nv"]) -> JointSpline:
        """Return the curve with these control points."""
        return joint_spline(self.path.group.joints, make_bspline(points))


@dataclass(frozen=True)
class TangentChart:
    """Tangents at one configuration as coordinates.

    Attributes:
        path: Path that the chart covers.
        base: The configuration, shape (nq,).
        waypoints: Waypoints of the path, in small steps.
    """

    path: JointPath
    base: Float64[np.ndarray, " nq"]
    waypoints: Float64[np.ndarray, "n nv"]

    @property
    def is_winding(self) -> bool:
        """Whether a joint turns farther from the base than half of any shortest path does."""
        return bool(rotation_angles(self.path.group, self.waypoints).max() > _MAX_MIDDLE_TANGENT)

    def positions(self, deltas: Float64[np.ndarray, "m nv"]) -> Float64[np.ndarray, "m nq"]:
        """Return base [+] delta."""
        return self._manifold.plus(self.base, deltas)

    def limits_in_chart(self, limits: JointLimits) -> JointLimits:
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

    def distance_query_in_chart(self, distance_query: DistanceQuery) -> DistanceQuery:
        """Return a distance query with gradients with respect to delta."""
        return _TangentDistanceQuery(distance_query, self)

    def velocity_jacobians(
        self, deltas: Float64[np.ndarray, "m nv"]
    ) -> Float64[np.ndarray, "m nv nv"]:
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
        flat = joint_spline(self.path.group.joints, make_bspline(points))
        coefficients = flat.coefficients.copy()
        coefficients[:, 0] += flat.bases
        bases = np.broadcast_to(self.base, (flat.num_pieces, len(self.base)))
        return JointSpline(self.path.group.joints, flat.breaks, bases, coefficients)

    @property
    def _manifold(self) -> Manifold:
        return Manifold(self.path.group.joints)


@dataclass(frozen=True)
class _TangentDistanceQuery:
    inner: DistanceQuery
    chart: TangentChart

    def within(self, qs: Float64[np.ndarray, "m nv"], influence_distance: float) -> DistanceRows:
        """Return the pairs with a signed margin below `influence_distance` [m]."""
        rows = self.inner.within(self.chart.positions(qs), influence_distance)
        jacobians = self.chart.velocity_jacobians(qs)[rows.sample_indices]
        return DistanceRows(
            rows.sample_indices,
            rows.signed_margins,
            np.einsum("mi,mij->mj", rows.gradients, jacobians),
        )


def make_chart(path: JointPath) -> FlatChart | TangentChart:
    """Return the chart of a path.

    If the path turns too far for one tangent space, it is the chart of the straight path between
    its ends instead.
    """
    manifold = Manifold(path.group.joints)
    if manifold.is_flat:
        return FlatChart(path)
    samples = _sample_path(path)
    middle = np.array([len(samples) // 2])
    base, deltas, longest = _best_base(path, samples, middle)
    if longest > _MAX_MIDDLE_TANGENT:
        candidates = np.linspace(0, len(samples) - 1, _MAX_BASES).astype(np.intp)
        base, deltas, longest = _best_base(path, samples, candidates)
    if longest > _MAX_TANGENT:
        return make_chart(path.straight)
    moves = np.linalg.norm(np.diff(deltas, axis=0), axis=1) > 1e-9
    return TangentChart(path, base, deltas[np.concatenate([[True], moves])])


def _sample_path(path: JointPath) -> Array:
    """Return configurations along a path, in small steps."""
    count = max(2, int(path.length / _SAMPLE_SPACING) + 1)
    return path.spline.positions(np.linspace(0.0, 1.0, count))


def _best_base(path: JointPath, samples: Array, anchors: Any) -> tuple[Array, Array, float]:
    """Return the best of several bases, the tangents there, and the longest of them [rad]."""
    tangents = tangents_along(path.group, samples, anchors)
    longest = rotation_angles(path.group, tangents).max(axis=(0, 2))
    best = int(longest.argmin())
    return samples[anchors[best]], tangents[:, best], float(longest[best])
