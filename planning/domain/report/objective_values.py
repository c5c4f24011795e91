"""ObjectiveValues: what one motion costs by each objective of the refinement."""

from dataclasses import dataclass

from planning.domain.request.refine_objective import RefineObjective
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class ObjectiveValues(Value):
    """Values of all objectives for one motion.

    Attributes:
        duration: [s].
        smoothness: Integral of the squared norm of the accelerations [rad^2/s^3], or of the jerks
            [rad^2/s^5]; None where accelerations jump, so that the second is infinite.
        energy: Integral of the squared norm of torques and forces [N^2 m^2 s]; None for groups
            with a floating joint.
        path_length: Joint-space length [rad or m].
    """

    duration: float
    smoothness: float | None
    energy: float | None
    path_length: float

    def cost(self, objective: RefineObjective) -> float:
        """Return the weighted sum; infinite where a value with a weight is missing."""
        total = objective.time_weight * self.duration + objective.path_length * self.path_length
        for weight, value in (
            (objective.smoothness, self.smoothness),
            (objective.energy, self.energy),
        ):
            if weight > 0:
                total += float("inf") if value is None else weight * value
        return total
