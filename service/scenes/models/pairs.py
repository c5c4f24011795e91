"""Pairs of bodies: how near they are, or why no check looks at them."""

from collections.abc import Sequence
from typing import Any, Literal, Self

from pydantic import ConfigDict, Field

from planning.domain.geometry import unchecked_pair as domain
from planning.domain.geometry.body_pair import BodyPair
from service.api.models import ResponseModel


class Pair(ResponseModel):
    """Two bodies and how near they are."""

    bodies: tuple[str, str] = Field(description="Full names")
    distance: float = Field(description="Signed distance [m]; negative is the depth of penetration")
    depth: float = Field(description="Depth of penetration [m]; 0 if they do not touch", ge=0)
    points: list[list[float]] = Field(description="Nearest point of each body, in world [m]")

    @classmethod
    def from_domain(cls, pair: BodyPair) -> Self:
        """Return a pair, which is not validated again: of many configurations there are many."""
        return cls.model_construct(
            bodies=pair.bodies,
            distance=pair.distance,
            depth=max(0.0, -pair.distance),
            points=pair.points.tolist(),
        )


class UncheckedPair(ResponseModel):
    """Two bodies that no collision check looks at."""

    model_config = ConfigDict(title="UncheckedPair")

    bodies: tuple[str, str] = Field(description="Full names of the bodies, sorted")
    reason: Literal["allowed", "held", "welded", "welded_to_world", "adjacent"] = Field(
        description="allowed: by the scene or the robot's description; held: one is attached and "
        "may touch the other; welded: neither can move relative to the other; welded_to_world: "
        "both stand in the world; adjacent: a joint joins them, and their shapes touch about it or "
        "can never touch"
    )
    evidence: str = Field(description="Evidence for the reason, in words")


def unchecked_pairs(pairs: Sequence[domain.UncheckedPair]) -> list[dict[str, Any]]:
    """Return the same as JSON; of thousands of objects there are too many to make models of."""
    return [
        {"bodies": list(pair.bodies), "reason": pair.reason, "evidence": pair.evidence}
        for pair in pairs
    ]
