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
from planning.refine.constraints.path_load import PathLoad
from planning.refine.curves.duration_bound import rest_to_rest_durations
from planning.world.mechanics.tool_kinematics import ToolKinematics

# Step of the difference quotient for J', as a displacement of the joints [rad or m].
_DIFFERENCE_STEP = 1e-4
# Sides of half the polygon. Its apothem is 1 - cos(pi / 96), 0.05 %, less than the disc's radius:
# with a larger difference the model, which has the disc, would predict a gain that no step
# achieves.
_NUM_SIDES = 48
_ANGLES = (np.arange(_NUM_SIDES) + 0.5) * np.pi / _NUM_SIDES
_APOTHEM = float(np.cos(np.pi / (2 * _NUM_SIDES)))
_TINY = 1e-300


@dataclass(frozen=True)
class ToolLoad:
    """Speed and acceleration limits of one frame; at least one of them is set.

    Attributes:
        kinematics: Kinematics of the frame.
        limit: Limits on speed [m/s] and acceleration [m/s^2].
    """

    kinematics: ToolKinematics
    limit: ToolLimit

    @property
    def num_parts(self) -> int:
        """One part per grid interval."""
        return 1

    def load_ratios(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return velocity and acceleration over their limits, those that are limited."""
        if self.limit.acceleration is None:
            return (self.kinematics.velocities(q, v) / self._max_speed)[:, None]
        velocity, acceleration = self._velocity_and_acceleration(q, v, vdot)
        acceleration_ratios = acceleration / self._max_acceleration
        if self.limit.speed is None:
            return acceleration_ratios[:, None]
        return np.stack([velocity / self._max_speed, acceleration_ratios], axis=1)

    def along(self, q: Array, rate: Array, curvature: Array) -> PathLoad:
        """Return one row for the speed, and the polygon's rows for the acceleration."""
        no_static_load = np.zeros((len(q), 0))
        if self.limit.acceleration is None:
            tangent = self.kinematics.velocities(q, rate)
            speed_rows = (_lengths(tangent) / self._max_speed) ** 2
            rows = np.zeros_like(speed_rows), speed_rows
            by_root = (tangent / self._max_speed)[:, None]
            return PathLoad(rows, no_static_load, by_root=by_root)
        tangent, second_derivative = self._velocity_and_acceleration(q, rate, curvature)
        tangent_length, speed_rows = _lengths(tangent), (_lengths(tangent) / self._max_speed) ** 2
        unit = tangent / np.maximum(tangent_length, _TINY)
        along = np.sum(second_derivative * unit, axis=1, keepdims=True)
        across = _lengths(second_derivative - along * unit)
        radius = self._max_acceleration * _APOTHEM
        cosines, sines = np.cos(_ANGLES), np.sin(_ANGLES)
        rows = (
            np.concatenate([np.zeros_like(speed_rows), cosines * tangent_length / radius], axis=1),
            np.concatenate([speed_rows, (cosines * along + sines * across) / radius], axis=1),
        )
        by_u, by_b = (
            (part / self._max_acceleration)[:, None] for part in (tangent, second_derivative)
        )
        by_root = None
        if self.limit.speed is not None:
            none = np.zeros_like(by_u)
            by_root = np.concatenate([(tangent / self._max_speed)[:, None], none], axis=1)
            by_u, by_b = (np.concatenate([none, part], axis=1) for part in (by_u, by_b))
        return PathLoad(rows, no_static_load, by_root=by_root, by_u=by_u, by_b=by_b)

    def derivatives(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return the derivatives of the load ratios.

        J is the derivative of the origin's position, so that d(J' v)/dv = 2 d(J v)/dq.
        """
        gradients = (
            self.kinematics.velocity_gradients(q, v) if self.limit.acceleration is None else None
        )
        if gradients is not None:
            jacobian = self.kinematics.velocity_jacobians(q)[:, 3:]
            by_velocity = np.stack([gradients, jacobian, np.zeros_like(jacobian)])
            return by_velocity[:, :, None] / self._max_speed
        # The two rows of a grid point differ in vdot alone.
        is_new = np.append(True, ((q[1:] != q[:-1]) | (v[1:] != v[:-1])).any(axis=1))[: len(q)]
        new_rows, row_indices = np.flatnonzero(is_new), np.cumsum(is_new) - 1
        velocities = v[new_rows]
        (jacobian_derivatives,) = difference_quotients(
            lambda at: self._jacobian_and_bias(at, velocities), q[new_rows]
        )
        by_q, jacobian = (
            jacobian_derivatives[row_indices, :, : q.shape[1]],
            self.kinematics.velocity_jacobians(q)[:, 3:],
        )
        velocity_by_q = np.einsum("mijk,mj->mik", by_q, v)
        zeros = np.zeros_like(jacobian)
        by_velocity = np.stack([velocity_by_q, jacobian, zeros]) / self._max_speed
        if self.limit.acceleration is None:
            return by_velocity[:, :, None]
        acceleration_by_q = (
            np.einsum("mijk,mj->mik", by_q, vdot) + jacobian_derivatives[row_indices, :, -1]
        )
        by_acceleration = (
            np.stack([acceleration_by_q, 2 * velocity_by_q, jacobian]) / self._max_acceleration
        )
        if self.limit.speed is None:
            return by_acceleration[:, :, None]
        return np.stack([by_velocity, by_acceleration], axis=2)

    def static_load(self, q: Array) -> Array:
        """Return no columns: a frame at rest has no load."""
        return np.zeros((len(q), 0))

    def duration_lower_bound(self, ends: Array) -> float:
        """Return the duration of the straight line in space between the end positions [s]."""
        _, p_wt = self.kinematics.poses(ends)
        distance = float(np.linalg.norm(p_wt[1] - p_wt[0]))
        return float(
            rest_to_rest_durations(np.array([distance]), self._max_speed, self._max_acceleration)[0]
        )

    @property
    def _max_speed(self) -> float:
        return np.inf if self.limit.speed is None else self.limit.speed

    @property
    def _max_acceleration(self) -> float:
        return np.inf if self.limit.acceleration is None else self.limit.acceleration

    def _jacobian_and_bias(self, q: Array, v: Array) -> Array:
        """Return J, with J' v as another column if accelerations count; rows of v repeat.

        Shape (m, 3, nq) or (m, 3, nq + 1).
        """
        jacobians = self.kinematics.velocity_jacobians(q)[:, 3:]
        if self.limit.acceleration is None:
            return jacobians
        bias = self._bias_acceleration(q, tile_rows(v, len(q)))
        return np.concatenate([jacobians, bias[:, :, None]], axis=2)

    def _velocity_and_acceleration(self, q: Array, v: Array, vdot: Array) -> tuple[Array, Array]:
        """Return the origin's velocity and acceleration: J v, and J vdot + J' v."""
        jacobians = self.kinematics.velocity_jacobians(q)[:, 3:]
        velocity, jacobian_acceleration = (
            np.einsum("mij,mj->mi", jacobians, rate) for rate in (v, vdot)
        )
        return velocity, jacobian_acceleration + self._bias_acceleration(q, v)

    def _bias_acceleration(self, q: Array, v: Array) -> Array:
        """Return J' v."""
        time_step = _DIFFERENCE_STEP / np.maximum(_lengths(v), _TINY)
        configurations = np.concatenate([q + time_step * v, q - time_step * v])
        after, before = self.kinematics.velocities(configurations, np.concatenate([v, v])).reshape(
            2, -1, 3
        )
        return (after - before) / (2 * time_step)


def tile_rows(rows: Array, count: int) -> Array:
    """Return rows repeated as a block, `count` in total."""
    return np.tile(rows, (count // max(len(rows), 1), 1))


def _lengths(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1, keepdims=True)
