"""What there is to choose from, in JSON: the names of robots, and planners."""

from typing import Literal

from pydantic import ConfigDict, Field

from service.api.models import ResponseModel


class ModelList(ResponseModel):
    """Robots there are."""

    items: list[str] = Field(description="Names, sorted; GET /v1/models/{name} says more")


class Parameter(ResponseModel):
    """A parameter of a planner."""

    model_config = ConfigDict(from_attributes=True)

    name: str = Field(description="OMPL's name")
    default: str = Field(description="Its value if it is not given, as text")
    range: str = Field(description="The values that it may have, for a person")
    type: Literal["boolean", "integer", "number"] = Field(description="JSON type of its values")
    minimum: float | None = Field(description="Least value, or null where there is none")
    maximum: float | None = Field(description="Greatest value, or null where there is none")


class Planner(ResponseModel):
    """A planner that a plan may name."""

    model_config = ConfigDict(title="Planner", from_attributes=True)

    name: str = Field(description="Name of the planner in OMPL, or `GCS`")
    needs_regions: bool = Field(
        description="Whether it plans inside regions, see POST /v1/scenes/{id}/regions"
    )
    parameters: list[Parameter] = Field(description="Parameters that can be set")


class PlannerList(ResponseModel):
    """All planners."""

    items: list[Planner] = Field(description="Planners, sorted by name")
