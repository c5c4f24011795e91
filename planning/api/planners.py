"""list_planners(): all planners that search options may name."""

from planning.domain.planner.planner_card import PlannerCard
from planning.pipeline.gcs_planner import GCS_CARD
from planning.search.ompl.planner_list import ompl_cards


def list_planners() -> tuple[PlannerCard, ...]:
    """Return all planners with their parameters, sorted by name: OMPL's, and GCS."""
    return tuple(sorted((GCS_CARD, *ompl_cards()), key=lambda card: card.name))
