"""TorqueLoad: torques and forces of joints, over their limits.

Along a curve tau = ahead u + bend b + held: what holds the robot still does not slow down with it.
Of a limit only what gravity leaves is left to the motion; where gravity takes more than it may,
what it takes at most leaves. That is too little to go on, but tells a better way from a worse one.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.load import MOST_HELD, difference_quotients
from planning.world.mechanics.dynamics import GroupDynamics

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True)
class TorqueLoad:
    """Of the joints whose effort is limited. What damping takes is not in it.

    Attributes:
        dynamics: What a motion takes.
        columns: Coordinates that are limited, shape (k,).
        efforts: Their limits [N m or N], shape (k,).
    """

    dynamics: GroupDynamics
    columns: Indices
    efforts: Float64[np.ndarray, " k"]

    @classmethod
    def of(cls, dynamics: GroupDynamics, limits: JointLimits) -> "TorqueLoad":
        """Return the bounds that imply a group's limits."""
        efforts = limits.per_coordinate(limits.effort)
        columns = np.flatnonzero(np.isfinite(efforts) & (efforts > 0))
        return cls(dynamics, columns, efforts[columns])

    @property
    def parts(self) -> int:
        """The ends of intervals are enough."""
        return 1

    def vectors(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return torque over limit, a vector of one component for each joint."""
        held = self.held(q)
        beyond = held - np.clip(held, -MOST_HELD, MOST_HELD)
        return (self._ratios(q, v, vdot) - beyond)[:, :, None]

    def slopes(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return their derivatives by differences."""
        found = difference_quotients(self._ratios, q, v, vdot)
        is_beyond = np.abs(self.held(q)) > MOST_HELD
        some = np.flatnonzero(is_beyond.any(axis=1))
        (by_q,) = difference_quotients(self.held, q[some])
        found[0, some] -= np.where(is_beyond[some, :, None], by_q, 0.0)
        return found[:, :, :, None]

    def pace_rows(self, q: Array, rate: Array, curvature: Array) -> tuple[Array, Array]:
        """Return two rows for every joint, in units of what gravity leaves."""
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
        """Return what gravity takes."""
        still = np.zeros_like(q)
        return self._ratios(q, still, still)

    def least_duration(self, ends: Array) -> float:  # noqa: ARG002  (none is known)
        """Return 0."""
        return 0.0

    def _ratios(self, q: Array, v: Array, vdot: Array) -> Array:
        efforts = self.dynamics.efforts(q, v, vdot) - self.dynamics.damping * v
        return efforts[:, self.columns] / self.efforts
