"""UncheckedPair: two bodies that no collision check covers, and the reason."""

from dataclasses import dataclass
from typing import Literal

from planning.domain.value import Value

# `allowed`: the scene or the robot's own description allows their contact. `held`: one of them is
# attached, and may touch the other. `welded`: nothing can move one relative to the other.
# `welded_to_world`: the same, as both are fixed to the world. `adjacent`: one joint joins them, and
# their shapes overlap there by design, or can never touch.
type UncheckedReason = Literal["allowed", "held", "welded", "welded_to_world", "adjacent"]


@dataclass(frozen=True, eq=False)
class UncheckedPair(Value):
    """Two bodies with collision shapes whose distance is never checked.

    Attributes:
        bodies: Full names, sorted.
        reason: Why.
        evidence: Basis of the reason, in words.
    """

    bodies: tuple[str, str]
    reason: UncheckedReason
    evidence: str

    caches_bytes = True
