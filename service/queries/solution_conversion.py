"""Goal configurations and how good they are, to the wire."""

import dataclasses
from typing import TYPE_CHECKING, Any

from service.api.models import listed

if TYPE_CHECKING:
    import numpy as np

    from planning.domain.goals.configuration_quality import ConfigurationQuality


def solution_wire(
    q: "np.ndarray[Any, Any]", pose_index: int, quality: "ConfigurationQuality"
) -> dict[str, Any]:
    """Return a goal configuration for the wire."""
    return {
        "positions": listed(q),
        "pose_index": pose_index,
        "manipulability": quality.manipulability,
        "clearance": quality.clearance,
        "pair": quality.pair and list(quality.pair),
        "limit_margin": quality.limit_margin,
        "distance": quality.distance,
        "branch": quality.branch and dataclasses.asdict(quality.branch),
    }
