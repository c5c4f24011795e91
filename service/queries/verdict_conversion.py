"""Verdicts on configurations to the wire."""

from typing import TYPE_CHECKING, Any

from planning.domain.geometry.body_pair import BodyPair
from service.api.models import finite, listed

if TYPE_CHECKING:
    from planning.world.configuration_check import StateVerdict


def pair_wire(pair: BodyPair) -> dict[str, Any]:
    """Return two bodies and their distance for the wire."""
    return {
        "bodies": list(pair.bodies),
        "distance": pair.distance,
        "depth": max(0.0, -pair.distance),
        "points": listed(pair.points),
    }


def verdict_wire(verdict: "StateVerdict") -> dict[str, Any]:
    """Return a verdict for the wire."""
    nearest = verdict.nearest
    return {
        "valid": verdict.valid,
        "collisions": [pair_wire(pair) for pair in verdict.violations],
        "distance": None if nearest is None else nearest.distance,
        "nearest": None if nearest is None else pair_wire(nearest),
        "limit_violations": [
            {
                "joint": outside.joint,
                "value": outside.position,
                "lower": finite(outside.lower),
                "upper": finite(outside.upper),
            }
            for outside in verdict.limit_violations
        ],
    }
