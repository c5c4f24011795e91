"""UncheckedPair: two bodies that no collision check looks at, and why."""

from dataclasses import dataclass
from typing import Literal

from planning.domain.value import Value

# `allowed`: the scene or the robot's own description lets them touch. `held`: one of them is
# attached, and may touch the other. `welded`: nothing can move one relative to the other.
# `welded_to_world`: the same, as both stand in the world. `adjacent`: one joint joins them, and
# their shapes overlap there by design, or can never touch.
type UncheckedReason = Literal["allowed", "held", "welded", "welded_to_world", "adjacent"]


@dataclass(frozen=True, eq=False)
class UncheckedPair(Value):
    """Two bodies with collision shapes whose distance is never looked at.

    Attributes:
        bodies: Full names, sorted.
        reason: Why.
        evidence: What that rests on, in words.
    """

    bodies: tuple[str, str]
    reason: UncheckedReason
    evidence: str
