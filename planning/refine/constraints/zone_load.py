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
from planning.refine.constraints.tool_load import repeated
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Ranges before and behind a face over which the weight rises [m]. If they were equal, a motion
# would gain more behind the face than it loses before it, where it brakes anyway: with these values
# durations agree within 2 %.
_BEFORE, _BEHIND = 0.015, 0.005
# Half side of a box below which these ranges shrink in proportion [m].
_THICK = 0.02
# Parts per interval of the path velocity's grid.
_PARTS = 4


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
        return cls(box_of(world, group, zone), zone.speed)

    @property
    def parts(self) -> int:
        """Parts per grid interval, so that no visit of a zone falls between two samples."""
        return _PARTS

    def vectors(self, q: Array, v: Array, vdot: Array) -> Array:  # noqa: ARG002  (speed alone)
        """Return the velocity over the speed limit, times the weight of the zone."""
        return self._ratios(q, v)[:, None]

    def slopes(self, q: Array, v: Array, vdot: Array) -> Array:  # noqa: ARG002
        """Return the derivatives of the load ratios."""
        (by_q,) = difference_quotients(lambda at: self._ratios(at, repeated(v, len(at))), q)
        jacobian = self.box.motion.by_v(q)[:, 3:]
        by_v = jacobian * (self._slowness(q) / self.speed)[:, None, None]
        return np.stack([by_q, by_v, np.zeros_like(by_v)])[:, :, None]

    def pace_rows(self, q: Array, rate: Array, curvature: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return one row: the square of the speed over the limit."""
        steady = np.sum(self._ratios(q, rate) ** 2, axis=1, keepdims=True)
        return np.zeros_like(steady), steady

    def held(self, q: Array) -> Array:
        """Return no columns: a frame at rest has no load."""
        return np.zeros((len(q), 0))

    def least_duration(self, ends: Array) -> float:  # noqa: ARG002  (there may be a way around)
        """Return 0: there may be a path around the zone."""
        return 0.0

    def _ratios(self, q: Array, v: Array) -> Array:
        velocities = self.box.motion.velocities(q, v)
        return velocities * (self._slowness(q) / self.speed)[:, None]

    def _slowness(self, q: Array) -> Array:
        """Return the smooth weight of the zone in each row, 0 outside to 1 inside."""
        scale = min(1.0, float(self.box.half.min()) / _THICK)
        deep = _BEFORE * scale - self.box.spares(q)
        share = np.clip(deep / ((_BEFORE + _BEHIND) * scale), 0.0, 1.0)
        return share**2 * (3 - 2 * share)


def box_of(world: World, group: JointGroup, zone: SpeedZone) -> BoxConstraint:
    """Return a zone in world coordinates as a box to keep out of."""
    kinematics = ToolKinematics(world, group, zone.frame)
    half = zone.box.size / 2
    return BoxConstraint(zone.name, kinematics, zone.box.pose, half, is_inside=False)
