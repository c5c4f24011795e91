"""TorqueLoad: torques and forces of joints, over their limits.

Along a curve tau = ahead u + bend b + held: what holds the robot still does not slow down with it.
Of a limit only what gravity leaves is left to the motion.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.joints import JointLimits
from planning.refine.load import difference_quotients
from planning.world.dynamics import GroupDynamics

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]

# What is left for motion, at least, as a share of the limit, where gravity takes more than it may:
# too little to go on, but a better way has to be told from a worse one.
_LEAST = 0.02


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

    def vectors(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return torque over limit, a vector of one component for each joint."""
        efforts = self.dynamics.efforts(q, v, vdot) - self.dynamics.damping * v
        return (efforts[:, self.columns] / self.efforts)[:, :, None]

    def slopes(self, q: Array, v: Array, vdot: Array) -> Array:
        """Return their derivatives by differences."""
        return difference_quotients(self.vectors, q, v, vdot)

    def pace_rows(self, q: Array, rate: Array, curvature: Array) -> tuple[Array, Array]:
        """Return two rows for every joint, in units of what gravity leaves."""
        found = self.dynamics.along(q, rate, curvature)
        ahead, bend, held = (
            part[:, self.columns] / self.efforts for part in (found.ahead, found.bend, found.held)
        )
        more, less = np.maximum(1 - held, _LEAST), np.maximum(1 + held, _LEAST)
        return (
            np.concatenate([ahead / more, -ahead / less], axis=1),
            np.concatenate([bend / more, -bend / less], axis=1),
        )

    def held(self, q: Array) -> Array:
        """Return what gravity takes."""
        still = np.zeros_like(q)
        return self.vectors(q, still, still)[:, :, 0]

    def least_duration(self, ends: Array) -> float:  # noqa: ARG002  (none is known)
        """Return 0."""
        return 0.0
