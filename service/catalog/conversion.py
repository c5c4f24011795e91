"""Planners to the wire."""

import dataclasses
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from planning.domain.planner.planner_card import PlannerCard


def planner_wire(card: "PlannerCard") -> dict[str, Any]:
    """Return a planner for the wire."""
    parameters = [dataclasses.asdict(parameter) for parameter in card.parameters]
    return {"name": card.name, "needs_regions": card.needs_regions, "parameters": parameters}
