"""TorqueLoad: joint torques and forces, over their effort limits.

Along a curve tau = ahead u + bend b + held: the static part `held` does not shrink with the path
velocity. So the motion may use only what gravity leaves of a limit; where gravity takes more than
the largest static load, the motion gets what that load would leave. Such a curve is not feasible,
but its cost still distinguishes better curves from worse ones.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.load import MOST_HELD, difference_quotients
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
    def parts(self) -> int:
        """One part per grid interval."""
        return 1

    def vectors(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return torque over limit, a vector of one component for each joint."""
        held = self.held(q)
        beyond = held - np.clip(held, -MOST_HELD, MOST_HELD)
        return (self._ratios(q, v, vdot) - beyond)[:, :, None]

    def slopes(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return the derivatives of the load ratios by difference quotients."""
        found = difference_quotients(self._ratios, q, v, vdot)
        is_beyond = np.abs(self.held(q)) > MOST_HELD
        some = np.flatnonzero(is_beyond.any(axis=1))
        (by_q,) = difference_quotients(self.held, q[some])
        found[0, some] -= np.where(is_beyond[some, :, None], by_q, 0.0)
        return found[:, :, :, None]

    def pace_rows(self, q: Array, rate: Array, curvature: Array) -> tuple[Array, Array]:
        """Return two rows for every joint, in units of what gravity leaves of the limit."""
        found = self.dynamics.along(q, rate, curvature)
        ahead, bend, held = (
            part[:, self.columns] / self.efforts for part in (found.ahead, found.bend, found.held)
        )
        more, less = (np.maximum(1 + sign * held, 1 - MOST_HELD) for sign in (-1, 1))
        return (
            np.concatenate([ahead / more, -ahead / less], axis=1),
            np.concatenate([bend / more, -bend / less], axis=1),
        )

    def held(self, q: Array) -> Array:
        """Return the static load ratios: torques of gravity over limits."""
        still = np.zeros_like(q)
        return self._ratios(q, still, still)

    def least_duration(self, ends: Array) -> float:  # noqa: ARG002  (none is known)
        """Return 0: no other bound is known."""
        return 0.0

    def _ratios(self, q: Array, v: Array, vdot: Array) -> Array:
        efforts = self.dynamics.efforts(q, v, vdot) - self.dynamics.damping * v
        return efforts[:, self.columns] / self.efforts
