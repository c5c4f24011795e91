"""list_planners(): everybody whom a search may name."""

from planning.domain.planner_card import PlannerCard
from planning.guided import GCS_CARD
from planning.search.planners import ompl_cards


def list_planners() -> tuple[PlannerCard, ...]:
    """Return all planners with their parameters, sorted by name: OMPL's, and GCS."""
    return tuple(sorted((GCS_CARD, *ompl_cards()), key=lambda card: card.name))
