"""PlannerCard: name and parameters of a planner that a search may use."""

from dataclasses import dataclass
from typing import Literal

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PlannerParameter(Value):
    """Parameter of a planner.

    Attributes:
        name: OMPL's, or Drake's.
        default: Its value if it is not given, as text ("range" 0: chosen for the space).
        range: Permitted values, as text for people.
        type: JSON's name of its type.
        minimum: Its least value, None where it has none.
        maximum: Its greatest value, None where it has none.
    """

    name: str
    default: str
    range: str
    type: Literal["boolean", "integer", "number"]
    minimum: float | None
    maximum: float | None


@dataclass(frozen=True, eq=False)
class PlannerCard(Value):
    """Planner that a search may use.

    Attributes:
        name: OMPL's, or "GCS".
        parameters: Parameters, sorted by name.
        needs_regions: Whether it plans inside convex regions grown before.
    """

    name: str
    parameters: tuple[PlannerParameter, ...]
    needs_regions: bool = False
