"""ToolLoad: velocity and acceleration of a frame's origin, over their limits.

Along a curve the origin's path is p(s): p' = J r', p'' = J r'' + J' r'. Its speed |p'| sqrt(b)
bounds b alone. Its acceleration p'' b + p' u is in the half plane on one side of p', as b is not
negative: there the disc of admissible accelerations is replaced by half a polygon inside it.
"""

from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array
from planning.domain.request.motion_limits import ToolLimit
from planning.refine.constraints.load import difference_quotients
from planning.refine.curves.duration_bound import rest_to_rest
from planning.world.mechanics.tool_kinematics import ToolKinematics

# Step of the difference quotient for J', as a displacement of the joints [rad or m].
_STEP = 1e-4
# Sides of half the polygon. Its apothem is 1 - cos(pi / 96), 0.05 %, less than the disc's radius:
# with a larger difference the model, which has the disc, would predict a gain that no step
# achieves.
_SIDES = 48
_ANGLES = (np.arange(_SIDES) + 0.5) * np.pi / _SIDES
_APOTHEM = float(np.cos(np.pi / (2 * _SIDES)))
_TINY = 1e-300


@dataclass(frozen=True)
class ToolLoad:
    """Speed and acceleration limits of one frame; at least one of them is set.

    Attributes:
        kinematics: Of the frame.
        limit: Limits on speed [m/s] and acceleration [m/s^2].
    """

    kinematics: ToolKinematics
    limit: ToolLimit

    @property
    def parts(self) -> int:
        """One part per grid interval."""
        return 1

    def vectors(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return velocity and acceleration over their limits, those that are limited."""
        if self.limit.acceleration is None:
            return (self.kinematics.velocities(q, v) / self._speed)[:, None]
        velocity, acceleration = self._rates(q, v, vdot)
        pushed = acceleration / self._acceleration
        if self.limit.speed is None:
            return pushed[:, None]
        return np.stack([velocity / self._speed, pushed], axis=1)

    def pace_rows(self, q: Array, rate: Array, curvature: Array) -> tuple[Array, Array]:
        """Return one row for the speed, and the polygon's rows for the acceleration."""
        if self.limit.acceleration is None:
            way = self.kinematics.velocities(q, rate)
            steady = (_lengths(way) / self._speed) ** 2
            return np.zeros_like(steady), steady
        way, turn = self._rates(q, rate, curvature)
        ahead, steady = _lengths(way), (_lengths(way) / self._speed) ** 2
        unit = way / np.maximum(ahead, _TINY)
        straight = np.sum(turn * unit, axis=1, keepdims=True)
        across = _lengths(turn - straight * unit)
        radius = self._acceleration * _APOTHEM
        cosines, sines = np.cos(_ANGLES), np.sin(_ANGLES)
        return (
            np.concatenate([np.zeros_like(steady), cosines * ahead / radius], axis=1),
            np.concatenate([steady, (cosines * straight + sines * across) / radius], axis=1),
        )

    def slopes(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return the derivatives of the load ratios.

        J is the derivative of the origin's position, so that d(J' v)/dv = 2 d(J v)/dq.
        """
        # The two rows of a grid point differ in vdot alone.
        is_new = np.append(True, ((q[1:] != q[:-1]) | (v[1:] != v[:-1])).any(axis=1))[: len(q)]
        places, own = np.flatnonzero(is_new), np.cumsum(is_new) - 1
        swept = v[places]
        (found,) = difference_quotients(lambda at: self._swept(at, swept), q[places])
        by_q, jacobian = found[own, :, : q.shape[1]], self.kinematics.by_v(q)[:, 3:]
        turned = np.einsum("mijk,mj->mik", by_q, v)
        none = np.zeros_like(jacobian)
        by_velocity = np.stack([turned, jacobian, none]) / self._speed
        if self.limit.acceleration is None:
            return by_velocity[:, :, None]
        bent = np.einsum("mijk,mj->mik", by_q, vdot) + found[own, :, -1]
        by_acceleration = np.stack([bent, 2 * turned, jacobian]) / self._acceleration
        if self.limit.speed is None:
            return by_acceleration[:, :, None]
        return np.stack([by_velocity, by_acceleration], axis=2)

    def held(self, q: Array) -> Array:
        """Return no columns: a frame at rest has no load."""
        return np.zeros((len(q), 0))

    def least_duration(self, ends: Array) -> float:
        """Return the duration of the straight line in space between the end positions [s]."""
        _, p_wt = self.kinematics.poses(ends)
        way = float(np.linalg.norm(p_wt[1] - p_wt[0]))
        return float(rest_to_rest(np.array([way]), self._speed, self._acceleration)[0])

    @property
    def _speed(self) -> float:
        return np.inf if self.limit.speed is None else self.limit.speed

    @property
    def _acceleration(self) -> float:
        return np.inf if self.limit.acceleration is None else self.limit.acceleration

    def _swept(self, q: Array, v: Array) -> Array:
        """Return J, with J' v as another column if accelerations count; rows of v repeat.

        Shape (m, 3, nq) or (m, 3, nq + 1).
        """
        jacobians = self.kinematics.by_v(q)[:, 3:]
        if self.limit.acceleration is None:
            return jacobians
        bend = self._bend(q, repeated(v, len(q)))
        return np.concatenate([jacobians, bend[:, :, None]], axis=2)

    def _rates(self, q: Array, v: Array, vdot: Array) -> tuple[Array, Array]:
        """Return the origin's velocity and acceleration: J v, and J vdot + J' v."""
        jacobians = self.kinematics.by_v(q)[:, 3:]
        velocity, pushed = (np.einsum("mij,mj->mi", jacobians, rate) for rate in (v, vdot))
        return velocity, pushed + self._bend(q, v)

    def _bend(self, q: Array, v: Array) -> Array:
        """Return J' v."""
        reach = _STEP / np.maximum(_lengths(v), _TINY)
        ways = np.concatenate([q + reach * v, q - reach * v])
        later, sooner = self.kinematics.velocities(ways, np.concatenate([v, v])).reshape(2, -1, 3)
        return (later - sooner) / (2 * reach)


def repeated(rows: Array, count: int) -> Array:
    """Return rows repeated as a block, `count` in total."""
    return np.tile(rows, (count // max(len(rows), 1), 1))


def _lengths(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1, keepdims=True)
