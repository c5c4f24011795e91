"""How a plan searches for a path."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Strict, Tag

from planning.domain.request import options as domain
from planning.domain.robot.steering import Steering
from service.api.models import (
    WHOLE,
    Boolean,
    Identifier,
    Integer,
    Interval,
    JointOrBlockName,
    MobileJointName,
    Name,
    PositionName,
    Real,
    RequestModel,
)

type ParameterValue = Boolean | Integer | Real | Annotated[str, Field(max_length=256)]


class Roadmap(RequestModel):
    """A roadmap that many plans share; it is built once for a scene as a group sees it."""

    states: Annotated[int, Strict(), Field(ge=1, le=20_000), WHOLE] = Field(
        default=2_000, description="Number of free configurations that it has"
    )
    neighbours: Annotated[int, Strict(), Field(ge=1, le=100), WHOLE] = Field(
        default=12,
        description="Number of nearest others that each is joined with, where the way is free",
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="Seed of its samples; the plan's own seed does not change it"
    )

    def to_domain(self) -> domain.RoadmapOptions:
        """Return the domain's options of a roadmap."""
        return domain.RoadmapOptions(self.states, self.neighbours, self.seed)


class Car(RequestModel):
    """A planar base that moves like a car: never sideways, in no tighter turn than it can."""

    turning_radius: Annotated[Real, Field(ge=1e-3, le=1e3)] = Field(
        description="Radius of its tightest turn, at the origin of the base [m]"
    )
    reverse: Boolean = Field(
        default=True,
        description="Whether it drives backwards too (Reeds and Shepp's curves) or not (Dubins')",
    )

    def to_domain(self) -> Steering:
        """Return how the domain says that a base is steered."""
        return Steering(self.turning_radius, self.reverse)


def _kind_of_space(space: object) -> str:
    return "space[car]" if isinstance(space, dict | Car) else "space[name]"


# A fault names the alternative that was meant; steps in brackets are no part of its path.
type Space = Annotated[
    Annotated[Literal["full", "position"], Tag("space[name]")] | Annotated[Car, Tag("space[car]")],
    Discriminator(_kind_of_space),
    Field(description="Part of a joint that is searched, or the curves that a car of it can drive"),
]


class Search(RequestModel):
    """Options for finding a path."""

    planner: Name | Annotated[list[Name], Field(min_length=1, max_length=16)] = Field(
        default="RRTConnect",
        description="Name of the planner in OMPL, see GET /v1/planners; or several names, "
        "which take turns. `GCS` plans inside regions, and where it cannot "
        "the others do, by default RRTConnect",
    )
    regions: Identifier | None = Field(
        default=None,
        description="Id of the regions that GCS plans in; null for the newest that fit (a plan's "
        "`request` has the id of those), and where GCS is not among the planners",
    )
    parameters: dict[Name, ParameterValue] = Field(
        default={},
        max_length=64,
        description="Values of the planner's parameters, by their names in OMPL; of "
        "several planners, each takes those that it has",
    )
    attempts: Annotated[int, Strict(), Field(ge=1, le=100), WHOLE] = Field(
        default=1,
        description="Number of solutions to look for; the best by `objective` is kept. Of "
        "several planners each has at least one",
    )
    allowed_planning_time: Annotated[Real, Field(gt=0, le=3600)] = Field(
        default=5.0,
        description="Time for the whole plan, all stages, from when the scene is loaded "
        "[s]; stages that it cuts are in `result.cut_short`",
    )
    resolution: Annotated[Real, Field(ge=1e-4, le=10)] = Field(
        default=0.05,
        description="Largest joint-space distance between two checked states of an edge [rad or m]",
    )
    num_states: Annotated[int, Strict(), Field(ge=2, le=100_000), WHOLE] | None = Field(
        default=None, description="Least number of waypoints to which the path is interpolated"
    )
    weights: dict[JointOrBlockName, Annotated[Real, Field(ge=1e-3, le=1e3)]] = Field(
        default={},
        max_length=256,
        description="Factors of the metric that planners measure by [1], by name of a joint or of "
        "one of the group's `blocks`; 1 for what is not named",
    )
    bounds: dict[PositionName, Interval] = Field(
        default={},
        max_length=256,
        description="Lowest and highest value to search in [rad or m], by position name, within "
        "the limits",
    )
    spaces: dict[MobileJointName, Space] = Field(
        default={},
        max_length=64,
        description="Restrictions of joints, by name: `position` keeps the rotation of a "
        "planar or floating joint as it is at the start; a turning radius [m] "
        "makes a car of a planar joint",
    )
    setup_time: Annotated[Real, Field(gt=0, le=3600)] | None = Field(
        default=None,
        description="Time for setting up the space and the planner, in each attempt [s]; "
        "null for as long as it takes. An attempt that took longer gives up",
    )
    solve_time: Annotated[Real, Field(gt=0, le=3600)] | None = Field(
        default=None,
        description="Time for the planner, in each attempt [s]; null for as long as there is",
    )
    shortcut_time: Annotated[Real, Field(ge=0, le=3600)] | None = Field(
        default=None,
        description="Time for shortening each solution [s]; 0 for none, null for a share "
        "of the rest",
    )
    interpolate_time: Annotated[Real, Field(ge=0, le=3600)] | None = Field(
        default=None,
        description="Time for interpolating each solution to `num_states` [s]; null for "
        "as long as there is. One that takes longer stays as it was "
        "(`stages.search.interpolated`)",
    )
    objective: Literal["length", "weighted_length", "clearance", "duration"] = Field(
        default="length",
        description="Objective by which solutions are compared, and improved by planners that "
        "do so",
    )
    approximate: Boolean = Field(
        default=False,
        description="Whether a failure has, as evidence `approximate`, the reached configuration "
        "that is nearest to a goal",
    )
    keep_graph: Boolean = Field(
        default=False, description="Whether the planner's graph is kept for GET /plans/{id}/graph"
    )
    on_cancel: Literal["discard", "best"] = Field(
        default="discard",
        description="Scope of a cancel: the plan, or only the search if it has a path by "
        "then; that path is delivered if it can be timed and proven in 0.9 s",
    )
    approach_states: Annotated[int, Strict(), Field(ge=2, le=100_000), WHOLE] = Field(
        default=100,
        description="Least number of waypoints of each straight part; `num_states` is "
        "then for the free part",
    )
    roadmap: Roadmap | None = Field(
        default=None,
        description="Roadmap in which to look for a path first; the planner is used only "
        "where it has none. Under `path_constraints` it is one that keeps "
        "them",
    )

    @property
    def planners(self) -> list[str]:
        """The names of all planners."""
        return [self.planner] if isinstance(self.planner, str) else self.planner

    @property
    def cars(self) -> dict[str, Steering]:
        """How bases are to be steered, by the names of their joints."""
        spaces = self.spaces.items()
        return {name: space.to_domain() for name, space in spaces if isinstance(space, Car)}

    def to_domain(self) -> domain.SearchOptions:
        """Return the domain's search options."""
        return domain.SearchOptions(
            planner=self.planner if isinstance(self.planner, str) else tuple(self.planner),
            parameters=dict(self.parameters),
            attempts=self.attempts,
            allowed_planning_time=self.allowed_planning_time,
            resolution=self.resolution,
            num_states=self.num_states,
            approach_states=self.approach_states,
            weights=dict(self.weights),
            bounds={name: (low, high) for name, (low, high) in self.bounds.items()},
            spaces={
                name: space.to_domain() if isinstance(space, Car) else space
                for name, space in self.spaces.items()
            },
            setup_time=self.setup_time,
            solve_time=self.solve_time,
            shortcut_time=self.shortcut_time,
            interpolate_time=self.interpolate_time,
            objective=self.objective,
            approximate=self.approximate,
            keep_graph=self.keep_graph,
            on_cancel=self.on_cancel,
            roadmap=None if self.roadmap is None else self.roadmap.to_domain(),
        )
