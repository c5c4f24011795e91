"""ConstraintResidual: stacked residuals of constraints on sets too thin to be sampled."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.cone_constraint import ConeConstraint


@dataclass(frozen=True)
class ConstraintResidual:
    """Stacked residuals of some constraints; zero where all hold with their margins."""

    constraints: tuple[BoxConstraint | ConeConstraint, ...]

    @property
    def size(self) -> int:
        """Number of residuals."""
        return sum(
            3 if isinstance(constraint, BoxConstraint) else 1 for constraint in self.constraints
        )

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, " size"]:
        """Return the residuals at q, shape (nq,) [m or rad]."""
        return np.concatenate([constraint.residual(q) for constraint in self.constraints])

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "size nv"]:
        """Return the Jacobian of the residuals, zero in the rows that vanish."""
        return np.concatenate([constraint.jacobian(q) for constraint in self.constraints])
