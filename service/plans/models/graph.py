"""Planner graphs on the wire."""

from pydantic import ConfigDict, Field

from service.api.models import ResponseModel


class PlannerGraph(ResponseModel):
    """What a planner explored: trees or a roadmap, the first 2,000 vertices of it at most."""

    model_config = ConfigDict(title="PlannerGraph")

    planner: str = Field(description="OMPL's name; empty where a straight line was free")
    vertices: list[list[float]] = Field(description="The group's positions, a row each [rad or m]")
    edges: list[tuple[int, int]] = Field(description="Pairs of rows that motions join")
    starts: list[int] = Field(description="Rows of starts")
    goals: list[int] = Field(description="Rows of goals")
    path: list[int] = Field(
        description="Rows of the solution as the planner found it, before shortcutting, in order; "
        "empty if it found none"
    )
    num_vertices: int = Field(description="How many there were, those left out included")
    num_edges: int = Field(description="How many pairs there were, those left out included")
