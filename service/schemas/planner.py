"""Planners on the wire."""

from pydantic import ConfigDict, Field

from service.schemas.wire import Answer


class ParameterWire(Answer):
    """A parameter of a planner."""

    name: str = Field(description="OMPL's name")
    default: str = Field(description="Its value if it is not given, as text")
    range: str = Field(description="Values that OMPL suggests, or empty")


class PlannerWire(Answer):
    """A planner that a plan may name."""

    model_config = ConfigDict(title="Planner")

    name: str = Field(description="OMPL's name")
    parameters: list[ParameterWire] = Field(description="What can be set")


class PlannerList(Answer):
    """All planners."""

    items: list[PlannerWire] = Field(description="Sorted by name")
