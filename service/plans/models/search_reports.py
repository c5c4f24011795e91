"""What the search stage says about its work."""

from typing import Literal

from pydantic import ConfigDict, Field

from service.api.arrays import Rows
from service.api.document.known_values import AttemptOutcome
from service.api.models import ResponseModel


class AttemptReport(ResponseModel):
    """Outcome of one attempt at a solution."""

    planner: str = Field(description="Name of the planner in OMPL")
    outcome: AttemptOutcome = Field(
        description="`solved`, `collides` (on a closer look), `setup` (setting the planner up took "
        "longer than it may), or how it ended"
    )
    raw_length: float = Field(description="Length of its solution, before shortcutting [rad or m]")
    length: float = Field(description="Length of its solution, after shortcutting [rad or m]")
    cost: float = Field(description="Cost by the objective, in its unit")
    num_states_checked: int = Field(description="Configurations checked for collision")


class RegionsReport(ResponseModel):
    """Use of regions in a search."""

    digest: str = Field(
        description="Digest of the regions, whose id is `search.regions` of the plan's `request`"
    )
    num_regions: int = Field(description="Number of regions")
    considered: list[int] = Field(
        description="Places, in the list of regions, of those that the path was looked for in"
    )
    is_inside: bool = Field(description="Whether the path came from them")
    fallback: str = Field(description="Reason why it did not, or empty")


class RoadmapReport(ResponseModel):
    """Use of a roadmap; the same whether it was built for this plan or there already."""

    digest: str = Field(description="sha256 of its content")
    num_states: int = Field(description="Number of its configurations")
    num_edges: int = Field(description="Number of free ways between them")
    num_states_checked: int = Field(
        description="Number of configurations checked for collision to build it, whenever that was"
    )
    used: bool = Field(description="Whether the path that was kept is from the roadmap")
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
        description="Reason why it was not used, or empty: a straight line is better, no "
        "free way leads from the start or to a goal, none through it, its "
        "path is blocked on a closer look, the search ended before it "
        "answered, or its path was not proven"
    )


class SearchReport(ResponseModel):
    """Report of the search stage; lengths are in joint space [rad or m]."""

    planner: str = Field(
        description="Name in OMPL of the planner whose solution was kept; `roadmap` for a roadmap's"
    )
    attempts: int = Field(
        description="Number of attempts; 0 where a straight line was free (`direct`) or a "
        "roadmap knew a way, so that none was needed"
    )
    solved: int = Field(description="Number of attempts that found an exact solution")
    num_states_checked: int = Field(description="Configurations checked for collision")
    num_motions_checked: int = Field(description="Number of edges checked")
    raw_length: float = Field(
        description="Length of the kept solution, before shortcutting [rad or m]"
    )
    length: float = Field(description="And after it [rad or m]")
    num_waypoints: int = Field(description="Number of waypoints of the delivered path")
    resolution: float = Field(description="Resolution at which edges were checked [rad or m]")
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
        default=None, description="Use of regions, if the planner is GCS"
    )
    roadmap: RoadmapReport | None = Field(
        default=None, description="Use of a roadmap, if the request has one"
    )
    interpolated: bool = Field(
        default=True,
        description="Whether the path has `num_states` waypoints, if the request has it; false "
        "where `interpolate_time` was over before",
    )


class PlannerGraph(ResponseModel):
    """Graph that a planner explored: trees or a roadmap, at most the first 2,000 vertices of it."""

    model_config = ConfigDict(title="PlannerGraph")

    planner: str = Field(
        description="Name of the planner in OMPL; empty where a straight line was free"
    )
    vertices: Rows = Field(description="The group's positions, a row each [rad or m]")
    edges: list[tuple[int, int]] = Field(description="Pairs of rows that motions join")
    starts: list[int] = Field(description="Rows of starts")
    goals: list[int] = Field(description="Rows of goals")
    path: list[int] = Field(
        description="Rows of the solution as the planner found it, before shortcutting, in order; "
        "empty if it found none"
    )
    num_vertices: int = Field(description="Number of vertices, those left out included")
    num_edges: int = Field(description="Number of pairs, those left out included")
