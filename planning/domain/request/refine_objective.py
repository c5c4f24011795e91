"""RefineObjective: weights of what an optimized motion costs, and the bound on its duration."""

import math
from dataclasses import dataclass, replace
from typing import Literal

from planning.domain.goals.goal import Goal, LineGoal, PoseGoal, RegionGoal
from planning.domain.value import Value

# Weight of a second beside a weight of 1 on length: of the shortest motions the quickest is meant.
_TIE_BREAK = 1e-3
# What `smoothness` can integrate, with the order of the derivative.
DERIVATIVES = {"acceleration": 2, "jerk": 3}
# Largest weight, and largest bound on the duration [s].
MAX_WEIGHT = 1e9
MAX_DURATION = 86_400.0


@dataclass(frozen=True, eq=False)
class RefineObjective(Value):
    """Cost of a motion: weighted sum of its duration, smoothness, energy and length.

    Attributes:
        duration: Weight of the duration [1/s].
        smoothness: Weight of the integral over time of the squared norm of the joints'
            accelerations, or jerks; for the first [s^3/rad^2], for the second [s^5/rad^2].
        energy: Weight of the integral over time of the squared norm of the joints' torques and
            forces, gravity, damping and payload included [1/(N^2 m^2 s)].
        path_length: Weight of the joint-space length [1/rad or 1/m].
        derivative: What `smoothness` integrates.
        max_duration: Upper bound on the duration [s]; None for no bound.
    """

    duration: float = 0.0
    smoothness: float = 0.0
    energy: float = 0.0
    path_length: float = 0.0
    derivative: Literal["acceleration", "jerk"] = "acceleration"
    max_duration: float | None = None

    @property
    def weights(self) -> dict[str, float]:
        """The four weights, by name."""
        return {
            "duration": self.duration,
            "smoothness": self.smoothness,
            "energy": self.energy,
            "path_length": self.path_length,
        }

    @property
    def is_gentle(self) -> bool:
        """Whether a slower motion may cost less."""
        return self.smoothness > 0 or self.energy > 0

    @property
    def is_duration_alone(self) -> bool:
        """Whether nothing but the duration counts."""
        return not (self.is_gentle or self.path_length)

    @property
    def time_weight(self) -> float:
        """Weight of the duration; where only length counts, a small one that breaks ties [1/s]."""
        return self.duration or (0.0 if self.is_gentle else _TIE_BREAK * self.path_length)

    @property
    def derivative_order(self) -> int:
        """Order of the derivative that `smoothness` integrates: 2 or 3."""
        return DERIVATIVES[self.derivative]

    @property
    def normalized(self) -> "RefineObjective":
        """The same objective with the largest weight from 1 to 2, all scaled by a power of two."""
        _, exponent = math.frexp(max(self.weights.values()))
        weights = {name: math.ldexp(weight, 1 - exponent) for name, weight in self.weights.items()}
        return replace(self, **weights)

    def within(self, seconds: float | None) -> "RefineObjective":
        """Return the objective for a motion that may take no longer; None for no further bound."""
        if seconds is None or (self.max_duration is not None and self.max_duration <= seconds):
            return self
        return replace(self, max_duration=seconds)

    def fault_with(self, method: str) -> str:
        """Return why a method of refinement cannot minimize this, or ""."""
        if method == "none":
            return "method 'none' optimizes nothing: leave the objective out"
        if not any(self.weights.values()):
            return "one weight at least must be positive"
        if self.is_gentle and not self.duration and self.max_duration is None:
            return (
                "by smoothness and energy alone slower may always be better: give max_duration, or "
                "a weight of duration"
            )
        return ""

    def fault_beside(self, goal: Goal, duration: float | None) -> str:
        """Return why this cannot be asked for a goal and a requested duration [s], or ""."""
        longest = self.max_duration
        if isinstance(goal, LineGoal):
            asks_more = longest is not None or not self.is_duration_alone
            return "motions along lines are not optimized: leave it out" if asks_more else ""
        # Of a requested duration the linear moves have a part that is not known yet.
        has_moves = isinstance(goal, PoseGoal | RegionGoal) and (
            goal.approach is not None or goal.retreat is not None
        )
        if longest is None or duration is None or duration <= longest or has_moves:
            return ""
        return f"max_duration is {longest:g} s, but retime.duration is {duration:g} s"


# The objective where none is stated.
QUICKEST = RefineObjective(duration=1.0)
