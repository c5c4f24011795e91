"""ZoneLoad: velocity of a frame's origin inside a box (speed zone), over the zone's speed limit.

The indicator of a box has no gradient. It is replaced by a smooth weight that rises from 0 to 1
over two centimetres across the faces, so that the cost decreases for a curve that shortens its path
in the box or leaves it.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.request.motion_limits import SpeedZone
from planning.domain.robot.joints import JointGroup
from planning.refine.constraints.load import difference_quotients
from planning.refine.constraints.path_load import PathLoad
from planning.refine.constraints.tool_load import tile_rows
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Ranges before and behind a face over which the weight rises [m]. If they were equal, a motion
# would gain more behind the face than it loses before it, where it brakes anyway: with these values
# durations agree within 2 %.
_OUTER_RANGE, _INNER_RANGE = 0.015, 0.005
# Half side of a box below which these ranges shrink in proportion [m].
_MIN_HALF_SIDE = 0.02
# Parts per interval of the path velocity's grid.
_NUM_PARTS = 4
# Distance from the box that is the unit of rows for points outside [m].
EDGE_UNIT = 0.1
# Least speed over the limit whose tangent is taken: at 1 it allows no other speed.
_MIN_TANGENT_RATIO = 1.2
# Rounding error of a distance at which a point is at its tangent [m].
_ROUNDING = 1e-12


@dataclass(frozen=True, kw_only=True)
class ZonePathLoad(PathLoad):
    """Load of a zone along a curve.

    Attributes:
        local: Origins in the box's axes at the instants [m], shape (m, 3).
        margins: Their signed margins outside the box [m], shape (m,).
    """

    local: Float64[np.ndarray, "m 3"]
    margins: Float64[np.ndarray, " m"]


@dataclass(frozen=True)
class ZoneLoad:
    """Speed limit of one zone.

    Attributes:
        box: Box constraint, with the signed margin of the origin outside it.
        speed: Speed limit inside [m/s].
    """

    box: BoxConstraint
    speed: float

    @classmethod
    def of(cls, world: World, group: JointGroup, zone: SpeedZone) -> "ZoneLoad":
        """Return the load for a zone in world coordinates."""
        return cls(make_zone_constraint(world, group, zone), zone.speed)

    @property
    def num_parts(self) -> int:
        """Parts per grid interval, so that no visit of a zone falls between two samples."""
        return _NUM_PARTS

    def load_ratios(self, q: Array, v: Array, vdot: Array) -> Array:  # noqa: ARG002  (speed alone)
        """Return the velocity over the speed limit, times the weight of the zone."""
        return self._speed_ratios(q, v)[:, None]

    def derivatives(self, q: Array, v: Array, vdot: Array) -> Array:  # noqa: ARG002
        """Return the derivatives of the load ratios."""
        jacobian = self.box.kinematics.velocity_jacobians(q)[:, 3:]
        local = self.box.origins_in_box(q)
        fractions = self._fractions_at(self.box.margins_at(local))
        by_v = jacobian * (self._weights_of(fractions) / self.speed)[:, None, None]
        by_q = self._by_position(q, v, jacobian, local)
        return np.stack([by_q, by_v, np.zeros_like(by_v)])[:, :, None]

    def along(self, q: Array, rate: Array, curvature: Array) -> "ZonePathLoad":  # noqa: ARG002
        """Return one row: the square of the speed over the limit."""
        local = self.box.origins_in_box(q)
        margins = self.box.margins_at(local)
        by_root = self._weighted_speeds(q, rate, self._weights_at(margins))
        squares = np.sum(by_root**2, axis=1, keepdims=True)
        return ZonePathLoad(
            (np.zeros_like(squares), squares),
            np.zeros((len(q), 0)),
            by_root=by_root[:, None],
            local=local,
            margins=margins,
        )

    def edge_rows(
        self, margins: Float64[np.ndarray, " m"], ratios: Float64[np.ndarray, " m"]
    ) -> tuple[Array, Array, Array]:
        """Return linear rows, sums that must not exceed 1, for points near the box's faces.

        The weight w(d) at a signed margin d allows a speed of r(d) = 1 / w(d) limits, which rises
        from 1 behind a face to infinity before it and is convex. So each of its tangents allows
        less: what satisfies a row satisfies the limit. The tangent is taken at a point's own speed,
        where it has to keep its distance; or at its own margin, where it is slower than that.

        Args:
            margins: Signed margins outside the box, not behind the range of the weight [m].
            ratios: Speeds over the limit.

        Returns:
            Sums, and their derivatives by margins [1/m] and by ratios.
        """
        span = (_OUTER_RANGE + _INNER_RANGE) * self._scale
        at = np.maximum(ratios, _MIN_TANGENT_RATIO)
        # Where f^2 (3 - 2 f) = 1 / r.
        fractions = 0.5 - np.sin(np.arcsin(1 - 2 / at) / 3)
        slopes = at**2 * 6 * fractions * (1 - fractions) / span
        least = _OUTER_RANGE * self._scale - fractions * span + (ratios - at) / slopes
        own = self._fractions_at(margins)
        weights = self._weights_of(own)
        is_slower = margins < least - _ROUNDING
        return (
            np.where(is_slower, weights * ratios, 1 - (margins - least) / EDGE_UNIT),
            np.where(is_slower, -6 * own * (1 - own) / span * ratios, -1 / EDGE_UNIT),
            np.where(is_slower, weights, 1 / (slopes * EDGE_UNIT)),
        )

    @property
    def edge_range(self) -> tuple[float, float]:
        """Signed margins between which the weight rises [m]."""
        return -_INNER_RANGE * self._scale, _OUTER_RANGE * self._scale

    def static_load(self, q: Array) -> Array:
        """Return no columns: a frame at rest has no load."""
        return np.zeros((len(q), 0))

    def duration_lower_bound(self, ends: Array) -> float:  # noqa: ARG002  (there may be a way around)
        """Return 0: there may be a path around the zone."""
        return 0.0

    def _by_position(self, q: Array, v: Array, jacobian: Array, local: Array) -> Array:
        """Return the derivatives of the ratios by q: those of the velocity, and of the weight."""
        gradients = self.box.kinematics.velocity_gradients(q, v)
        if gradients is None:
            (by_q,) = difference_quotients(
                lambda at: self._speed_ratios(at, tile_rows(v, len(at))), q
            )
            return by_q
        # The weight is f^2 (3 - 2 f).
        fractions = self._fractions_at(self.box.margins_at(local))
        slopes = -6 * fractions * (1 - fractions) / ((_OUTER_RANGE + _INNER_RANGE) * self._scale)
        normals = slopes[:, None] * self.box.gradients_at(local)
        weight_by_q = (normals[:, None] @ jacobian)[:, 0]
        velocities = (jacobian @ v[:, :, None])[:, :, 0]
        weighted = gradients * self._weights_of(fractions)[:, None, None]
        return (weighted + velocities[:, :, None] * weight_by_q[:, None]) / self.speed

    def _speed_ratios(self, q: Array, v: Array) -> Array:
        margins = self.box.margins_at(self.box.origins_in_box(q))
        return self._weighted_speeds(q, v, self._weights_at(margins))

    def _weighted_speeds(self, q: Array, v: Array, weights: Array) -> Array:
        ratios, is_near = np.zeros((len(q), 3)), np.flatnonzero(weights)
        if len(is_near):
            velocities = self.box.kinematics.velocities(q[is_near], v[is_near])
            ratios[is_near] = velocities * (weights[is_near] / self.speed)[:, None]
        return ratios

    def _weights_at(self, margins: Array) -> Array:
        """Return the smooth weight of the zone in each row, 0 outside to 1 inside."""
        return self._weights_of(self._fractions_at(margins))

    def _fractions_at(self, margins: Array) -> Array:
        """Return where in the range of the weight signed margins [m] are, 0 before to 1 behind."""
        depth = _OUTER_RANGE * self._scale - margins
        return np.clip(depth / ((_OUTER_RANGE + _INNER_RANGE) * self._scale), 0.0, 1.0)

    @property
    def _scale(self) -> float:
        return min(1.0, float(self.box.half.min()) / _MIN_HALF_SIDE)

    def _weights_of(self, fractions: Array) -> Array:
        return fractions**2 * (3 - 2 * fractions)


def make_zone_constraint(world: World, group: JointGroup, zone: SpeedZone) -> BoxConstraint:
    """Return a zone in world coordinates as a box to keep out of."""
    kinematics = ToolKinematics(world, group, zone.frame)
    half = zone.box.size / 2
    return BoxConstraint(zone.name, kinematics, zone.box.pose, half, is_inside=False)
