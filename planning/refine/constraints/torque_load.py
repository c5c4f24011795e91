"""TorqueLoad: joint torques and forces, over their effort limits.

Along a curve tau = t_u u + t_b b + t_0: the static part t_0 (gravity) does not shrink with the path
velocity. So the motion may use only what gravity leaves of a limit; where gravity takes more than
the largest static load, the motion gets what that load would leave. Such a curve is not feasible,
but its cost still distinguishes better curves from worse ones.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.load import MAX_STATIC_LOAD, difference_quotients
from planning.refine.constraints.path_load import PathLoad
from planning.world.mechanics.dynamics import GroupDynamics


@dataclass(frozen=True)
class TorqueLoad:
    """Effort limits of joints. Torques of damping are left out.

    Attributes:
        dynamics: Inverse dynamics of the group.
        columns: Coordinates with a limit, shape (k,).
        efforts: Their limits [N m or N], shape (k,).
    """

    dynamics: GroupDynamics
    columns: Indices
    efforts: Float64[np.ndarray, " k"]

    @classmethod
    def of(cls, dynamics: GroupDynamics, limits: JointLimits) -> "TorqueLoad":
        """Return the load for the finite effort limits of a group."""
        efforts = limits.per_coordinate(limits.effort)
        columns = np.flatnonzero(np.isfinite(efforts) & (efforts > 0))
        return cls(dynamics, columns, efforts[columns])

    @property
    def num_parts(self) -> int:
        """One part per grid interval."""
        return 1

    def load_ratios(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return torque over limit, a vector of one component for each joint."""
        static_loads = self.static_load(q)
        excess = static_loads - np.clip(static_loads, -MAX_STATIC_LOAD, MAX_STATIC_LOAD)
        return (self._torque_ratios(q, v, vdot) - excess)[:, :, None]

    def derivatives(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return the derivatives of the load ratios."""
        by_argument = self._slopes(q, v, vdot)
        is_excessive = np.abs(self.static_load(q)) > MAX_STATIC_LOAD
        excessive_rows = np.flatnonzero(is_excessive.any(axis=1))
        if not len(excessive_rows):
            return by_argument[:, :, :, None]
        (by_q,) = difference_quotients(self.static_load, q[excessive_rows])
        by_argument[0, excessive_rows] -= np.where(is_excessive[excessive_rows, :, None], by_q, 0.0)
        return by_argument[:, :, :, None]

    def _slopes(self, q: Array, v: Array, vdot: Array) -> Array:
        efforts = self.dynamics.derivatives(q, v, vdot)
        if efforts is None:
            return difference_quotients(self._torque_ratios, q, v, vdot)
        return efforts[:, :, self.columns] / self.efforts[:, None]

    def along(self, q: Array, rate: Array, curvature: Array) -> PathLoad:
        """Return two rows for every joint, in units of what gravity leaves of the limit."""
        path_efforts = self.dynamics.path_efforts(q, rate, curvature)
        by_u, by_b, static_loads = (
            part[:, self.columns] / self.efforts
            for part in (
                path_efforts.by_path_acceleration,
                path_efforts.by_squared_velocity,
                path_efforts.static,
            )
        )
        upper_reserve, lower_reserve = (
            np.maximum(1 + sign * static_loads, 1 - MAX_STATIC_LOAD) for sign in (-1, 1)
        )
        rows = (
            np.concatenate([by_u / upper_reserve, -by_u / lower_reserve], axis=1),
            np.concatenate([by_b / upper_reserve, -by_b / lower_reserve], axis=1),
        )
        rest = np.clip(static_loads, -MAX_STATIC_LOAD, MAX_STATIC_LOAD)
        return PathLoad(
            rows,
            static_loads,
            by_u=by_u[:, :, None],
            by_b=by_b[:, :, None],
            rest=rest[:, :, None],
        )

    def static_load(self, q: Array) -> Array:
        """Return the static load ratios: torques of gravity over limits."""
        zeros = np.zeros_like(q)
        return self._torque_ratios(q, zeros, zeros)

    def duration_lower_bound(self, ends: Array) -> float:  # noqa: ARG002  (none is known)
        """Return 0: no other bound is known."""
        return 0.0

    def _torque_ratios(self, q: Array, v: Array, vdot: Array) -> Array:
        efforts = self.dynamics.efforts(q, v, vdot) - self.dynamics.damping * v
        return efforts[:, self.columns] / self.efforts
