"""ZoneLoad: how fast the origin of a frame moves in a box, over the box's speed.

Whether a point is in a box has no slope. Here it is so by a share that rises from 0 to 1 over two
centimetres about the faces, so that a curve that shortens its way in the box, or leaves it, finds
that it gains.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.domain.request.motion_limits import SpeedZone
from planning.domain.robot.joints import JointGroup
from planning.refine.constraints.load import difference_quotients
from planning.refine.constraints.tool_load import repeated
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# How far before a face, and behind it, a point is partly in [m]. With as much on both sides a
# motion would win more behind it than it loses before it, where it brakes anyway: durations come
# out within 2 % so.
_BEFORE, _BEHIND = 0.015, 0.005
# In a box with half a side shorter than this they are as much less [m].
_THICK = 0.02
# Into which the intervals of the pace's grid are cut.
_PARTS = 4


@dataclass(frozen=True)
class ZoneLoad:
    """One zone.

    Attributes:
        box: Tells how far out of it the origin is.
        speed: At most, in it [m/s].
    """

    box: BoxConstraint
    speed: float

    @classmethod
    def of(cls, world: World, group: JointGroup, zone: SpeedZone) -> "ZoneLoad":
        """Prepare for a zone in world."""
        return cls(box_of(world, group, zone), zone.speed)

    @property
    def parts(self) -> int:
        """A curve must not find a way through between two looks."""
        return _PARTS

    def vectors(self, q: Array, v: Array, vdot: Array) -> Array:  # noqa: ARG002  (speed alone)
        """Return the velocity over the speed, by the share that is in."""
        return self._ratios(q, v)[:, None]

    def slopes(self, q: Array, v: Array, vdot: Array) -> Array:  # noqa: ARG002
        """Return the vectors' derivatives."""
        (by_q,) = difference_quotients(lambda at: self._ratios(at, repeated(v, len(at))), q)
        jacobian = self.box.motion.by_v(q)[:, 3:]
        by_v = jacobian * (self._slowness(q) / self.speed)[:, None, None]
        return np.stack([by_q, by_v, np.zeros_like(by_v)])[:, :, None]

    def pace_rows(self, q: Array, rate: Array, curvature: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return one row: the square of the speed."""
        steady = np.sum(self._ratios(q, rate) ** 2, axis=1, keepdims=True)
        return np.zeros_like(steady), steady

    def held(self, q: Array) -> Array:
        """Return nothing."""
        return np.zeros((len(q), 0))

    def least_duration(self, ends: Array) -> float:  # noqa: ARG002  (there may be a way around)
        """Return 0."""
        return 0.0

    def _ratios(self, q: Array, v: Array) -> Array:
        velocities = self.box.motion.velocities(q, v)
        return velocities * (self._slowness(q) / self.speed)[:, None]

    def _slowness(self, q: Array) -> Array:
        """Return by which share each row is in: smooth."""
        scale = min(1.0, float(self.box.half.min()) / _THICK)
        deep = _BEFORE * scale - self.box.spares(q)
        share = np.clip(deep / ((_BEFORE + _BEHIND) * scale), 0.0, 1.0)
        return share**2 * (3 - 2 * share)


def box_of(world: World, group: JointGroup, zone: SpeedZone) -> BoxConstraint:
    """Return a zone in world as a box to keep out of."""
    kinematics = ToolKinematics(world, group, zone.frame)
    half = zone.box.size / 2
    return BoxConstraint(zone.name, kinematics, zone.box.pose, half, is_inside=False)
