"""What the search stage says about its work."""

from typing import Literal

from pydantic import ConfigDict, Field

from service.api.arrays import Rows
from service.api.models import ResponseModel


class AttemptReport(ResponseModel):
    """What one attempt at a solution came to."""

    planner: str = Field(description="OMPL's name")
    outcome: str = Field(
        description="`solved`, `collides` (on a closer look), `setup` (setting the planner up took "
        "longer than it may), or how it ended"
    )
    raw_length: float = Field(description="Length of its solution, before shortcutting [rad or m]")
    length: float = Field(description="And after it [rad or m]")
    cost: float = Field(description="Cost by the objective, in its unit")
    num_states_checked: int = Field(description="Configurations checked for collision")


class RegionsReport(ResponseModel):
    """What regions were good for in a search."""

    digest: str = Field(
        description="Of the regions, whose id is `search.regions` of the plan's `request`"
    )
    num_regions: int = Field(description="How many there are")
    considered: list[int] = Field(description="Places of those that the path was looked for in")
    is_inside: bool = Field(description="Whether the path came from them")
    fallback: str = Field(description="Why it did not, or empty")


class RoadmapReport(ResponseModel):
    """What a roadmap did; the same whether it was built for this plan or there already."""

    digest: str = Field(description="sha256 of its content")
    num_states: int = Field(description="Its configurations")
    num_edges: int = Field(description="Free ways between them")
    num_states_checked: int = Field(
        description="Configurations checked for collision to build it, whenever that was"
    )
    used: bool = Field(description="Whether the path that was kept is one of its")
    reason: Literal[
        "",
        "straight_line",
        "start_not_joined",
        "goal_not_joined",
        "no_way",
        "blocked",
        "interrupted",
        "not_proven",
    ] = Field(
        description="Why not: a straight line is better, no free way leads from the start or to a "
        "goal, none through it, its path is blocked on a closer look, the search ended "
        "before it answered, or its path was not proven; or empty"
    )


class SearchReport(ResponseModel):
    """What the search stage did; lengths are in joint space [rad or m]."""

    planner: str = Field(
        description="OMPL's name; of several, whose solution was kept; `roadmap` for a roadmap's"
    )
    attempts: int = Field(
        description="How many were made; 0 where a straight line was free (`direct`) or a roadmap "
        "knew a way, so that none was needed"
    )
    solved: int = Field(description="How many of the attempts found an exact solution")
    num_states_checked: int = Field(description="Configurations checked for collision")
    num_motions_checked: int = Field(description="Edges checked")
    raw_length: float = Field(
        description="Length of the kept solution, before shortcutting [rad or m]"
    )
    length: float = Field(description="And after it [rad or m]")
    num_waypoints: int = Field(description="Number of waypoints of the delivered path")
    resolution: float = Field(description="At which edges were checked [rad or m]")
    padding: float = Field(description="Distance that was demanded beyond the margin [m]")
    direct: bool = Field(
        default=False,
        description="Whether the straight line was free, so that no search was needed",
    )
    objective: Literal["length", "weighted_length", "clearance", "duration"] = Field(
        default="length", description="Objective by which solutions were compared"
    )
    cost: float = Field(
        default=0.0,
        description="Cost of the kept solution: a length [rad or m], a duration [s], or, for "
        "clearance, "
        "length over distance",
    )
    attempts_log: list[AttemptReport] = Field(
        default=[], description="One entry per attempt, the first hundred"
    )
    was_canceled: bool = Field(default=False, description="Whether a cancel ended the search early")
    regions: RegionsReport | None = Field(
        default=None, description="What regions were good for, if the planner is GCS"
    )
    roadmap: RoadmapReport | None = Field(
        default=None, description="What a roadmap did, if the request has one"
    )
    interpolated: bool = Field(
        default=True,
        description="Whether the path has `num_states` waypoints, if the request has it; false "
        "where `interpolate_time` was over before",
    )


class PlannerGraph(ResponseModel):
    """What a planner explored: trees or a roadmap, the first 2,000 vertices of it at most."""

    model_config = ConfigDict(title="PlannerGraph")

    planner: str = Field(description="OMPL's name; empty where a straight line was free")
    vertices: Rows = Field(description="The group's positions, a row each [rad or m]")
    edges: list[tuple[int, int]] = Field(description="Pairs of rows that motions join")
    starts: list[int] = Field(description="Rows of starts")
    goals: list[int] = Field(description="Rows of goals")
    path: list[int] = Field(
        description="Rows of the solution as the planner found it, before shortcutting, in order; "
        "empty if it found none"
    )
    num_vertices: int = Field(description="How many there were, those left out included")
    num_edges: int = Field(description="How many pairs there were, those left out included")
