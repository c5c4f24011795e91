"""Which planners there are."""

from typing import Any

from planning.api.planners import list_planners
from service.catalog.conversion import planner_wire
from service.jobs.channel import Channel


def name_planners(_: dict[str, Any], __: Channel) -> dict[str, Any]:
    """Return all planners with their parameters."""
    return {"items": [planner_wire(card) for card in list_planners()]}
