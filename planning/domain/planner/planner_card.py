"""Cards of the planners that a search may name."""

from dataclasses import dataclass
from typing import Literal

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PlannerParameter(Value):
    """A parameter of a planner.

    Attributes:
        name: OMPL's, or Drake's.
        default: Its value if it is not given, as text ("range" 0: chosen for the space).
        range: The values that it may have, for a person.
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
    """A planner that a search may name.

    Attributes:
        name: OMPL's, or "GCS".
        parameters: What can be set, sorted by name.
        needs_regions: Whether it plans inside regions that were grown before.
    """

    name: str
    parameters: tuple[PlannerParameter, ...]
    needs_regions: bool = False
