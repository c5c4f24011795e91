"""ZoneLoad: velocity of a frame's origin inside a box (speed zone), over the zone's speed limit.

The indicator of a box has no gradient. It is replaced by a smooth weight that rises from 0 to 1
over two centimetres across the faces, so that the cost decreases for a curve that shortens its path
in the box or leaves it.
"""

from dataclasses import dataclass

import numpy as np

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
# Least speed over the limit for which a point outside is kept there, and the distance to the box
# that is the unit of that [m].
_MIN_SPEED_RATIO, _OUTSIDE_UNIT = 1.2, 0.1


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
        fractions = self._fractions(local)
        by_v = jacobian * (self._weights_of(fractions) / self.speed)[:, None, None]
        by_q = self._by_position(q, v, jacobian, local)
        return np.stack([by_q, by_v, np.zeros_like(by_v)])[:, :, None]

    def along(self, q: Array, rate: Array, curvature: Array) -> PathLoad:  # noqa: ARG002
        """Return one row: the square of the speed over the limit."""
        by_root = self._speed_ratios(q, rate)
        squares = np.sum(by_root**2, axis=1, keepdims=True)
        rows = np.zeros_like(squares), squares
        return PathLoad(rows, np.zeros((len(q), 0)), by_root=by_root[:, None])

    def edge(self, q: Array, v: Array) -> tuple[Array, Array, Array, Array] | None:
        """Prototype: indices, ratios (k,), derivatives (3, k, nq), taken mask (m,)."""
        local = self.box.origins_in_box(q)
        margins = self.box.margins_at(local)
        reach, span = _OUTER_RANGE * self._scale, (_OUTER_RANGE + _INNER_RANGE) * self._scale
        taken = margins > -_INNER_RANGE * self._scale
        near = np.flatnonzero(taken & (margins < reach + 0.7 * _OUTSIDE_UNIT))
        if not len(near):
            return None
        q, v, local, margins = q[near], v[near], local[near], margins[near]
        grads = self.box.kinematics.velocity_gradients(q, v)
        if grads is None:
            return None
        jacobian = self.box.kinematics.velocity_jacobians(q)[:, 3:]
        velocity = (jacobian @ v[:, :, None])[:, :, 0]
        speed = np.linalg.norm(velocity, axis=1)
        ratio = speed / self.speed
        at = np.maximum(ratio, _MIN_SPEED_RATIO)
        # weight(f) = 1 / at
        f = 0.5 - np.sin(np.arcsin(1 - 2 / at) / 3)
        slope = at**2 * 6 * f * (1 - f) / span   # d(at)/d(margin)
        line = reach - f * span + (ratio - at) / slope
        outside = margins >= line - 1e-12
        values = 1 - (margins - line) / _OUTSIDE_UNIT
        by_margin, by_ratio = np.full(len(q), -1 / _OUTSIDE_UNIT), 1 / slope / _OUTSIDE_UNIT
        # in the band, slower than the line
        fr = self._fractions(local)
        w = self._weights_of(fr)
        inner = ~outside
        values[inner] = (w * ratio)[inner]
        by_margin[inner] = (-6 * fr * (1 - fr) / span * ratio)[inner]
        by_ratio[inner] = w[inner]
        k = np.flatnonzero((values > 0.3) & (ratio > 0.5))
        normals = self.box.gradients_at(local[k])
        unit = velocity[k] / np.maximum(speed[k], 1e-12)[:, None] / self.speed
        J = jacobian[k]
        by_q = by_margin[k, None] * (normals[:, None] @ J)[:, 0] + by_ratio[k, None] * (unit[:, None] @ grads[k])[:, 0]
        by_v = by_ratio[k, None] * (unit[:, None] @ J)[:, 0]
        return near[k], values[k], np.stack([by_q, by_v, np.zeros_like(by_v)]), taken

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
        fractions = self._fractions(local)
        slopes = -6 * fractions * (1 - fractions) / ((_OUTER_RANGE + _INNER_RANGE) * self._scale)
        normals = slopes[:, None] * self.box.gradients_at(local)
        weight_by_q = (normals[:, None] @ jacobian)[:, 0]
        velocities = (jacobian @ v[:, :, None])[:, :, 0]
        weighted = gradients * self._weights_of(fractions)[:, None, None]
        return (weighted + velocities[:, :, None] * weight_by_q[:, None]) / self.speed

    def _speed_ratios(self, q: Array, v: Array) -> Array:
        weights = self._zone_weights(q)
        ratios, is_near = np.zeros((len(q), 3)), np.flatnonzero(weights)
        if len(is_near):
            velocities = self.box.kinematics.velocities(q[is_near], v[is_near])
            ratios[is_near] = velocities * (weights[is_near] / self.speed)[:, None]
        return ratios

    def _zone_weights(self, q: Array) -> Array:
        """Return the smooth weight of the zone in each row, 0 outside to 1 inside."""
        return self._weights_of(self._fractions(self.box.origins_in_box(q)))

    def _fractions(self, local: Array) -> Array:
        """Return where in the range of the weight each row is, 0 before to 1 behind.

        Args:
            local: Origins in the box's frame [m], shape (m, 3).
        """
        depth = _OUTER_RANGE * self._scale - self.box.margins_at(local)
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
