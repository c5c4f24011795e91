"""PlanRequest: what to plan."""

from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, Strict, model_validator

from service.schemas.constraint import ConstraintWire
from service.schemas.goal import GoalWire
from service.schemas.motion_limit import MotionLimits
from service.schemas.numbers import (
    WHOLE,
    Coordinate,
    Integer,
    NonNegative,
    Positions,
    Real,
    Scale,
)
from service.schemas.wire import Identifier, Name, Wire

type Interval = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
type ParameterValue = bool | Integer | Real | Annotated[str, Field(max_length=256)]

EXAMPLE: dict[str, Any] = {
    "scene": "scn_3f0c5b1e9a7d4c62",
    "group": "arm",
    "start": None,
    "goal": {
        "type": "pose",
        "poses": [{"position": [0.4, 0.2, 0.3], "quaternion": [0, 1, 0, 0]}],
        "frame": "arm::tool0",
    },
    "search": {"planner": "RRTConnect", "allowed_planning_time": 5.0},
    "retime": {"method": "toppra", "velocity_scale": 0.5},
    "seed": 7,
}


class PoseMetricWire(Wire):
    """How far apart two poses are: sqrt((translation * t)^2 + (rotation * angle)^2)."""

    translation: Annotated[Real, Field(ge=1e-3, le=1e3)] = Field(
        default=1.0, description="Weight of a metre [1/m]"
    )
    rotation: Annotated[Real, Field(ge=1e-3, le=1e3)] = Field(
        default=0.1,
        description="Weight of a radian [1/rad]; by default one weighs as much as 0.1 m",
    )


class IkWire(Wire):
    """How hard to look for goal configurations, and which of them are near."""

    max_configurations: Annotated[int, Strict(), Field(ge=1, le=10_000), WHOLE] = Field(
        default=100, description="Stop at this many distinct free ones"
    )
    max_trials: Annotated[int, Strict(), Field(ge=1, le=100_000), WHOLE] = Field(
        default=300, description="Stop after this many seeds of the solver, over all poses"
    )
    joint_weights: dict[Name, NonNegative] = Field(
        default={},
        max_length=256,
        description="Factor on each joint's part of the distance from the start, by full name "
        "(`robot::joint`); 1 for joints that are not named [1]",
    )
    pose_metric: PoseMetricWire = Field(
        default_factory=PoseMetricWire,
        description="Which pose is the nearest to one that no configuration reaches",
    )


class RoadmapWire(Wire):
    """A roadmap that many plans share; it is built once for a scene as a group sees it."""

    states: Annotated[int, Strict(), Field(ge=1, le=20_000), WHOLE] = Field(
        default=2_000, description="Free configurations that it has"
    )
    neighbours: Annotated[int, Strict(), Field(ge=1, le=100), WHOLE] = Field(
        default=12,
        description="With how many of the nearest others each is joined, where the way is free",
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="Of its samples; the plan's own seed does not change it"
    )


class CarWire(Wire):
    """A planar base that moves like a car: never sideways, in no tighter turn than it can."""

    turning_radius: Annotated[Real, Field(ge=1e-3, le=1e3)] = Field(
        description="Of its tightest turn, at the origin of the base [m]"
    )
    reverse: bool = Field(
        default=True,
        description="Whether it drives backwards too (Reeds and Shepp's curves) or not (Dubins')",
    )


class SearchWire(Wire):
    """How to search for a path."""

    planner: Name | Annotated[list[Name], Field(min_length=1, max_length=16)] = Field(
        default="RRTConnect",
        description="OMPL's name, see GET /v1/planners; or several, which take turns. `GCS` plans "
        "inside regions, and where it cannot the others do, by default RRTConnect",
    )
    regions: Identifier | None = Field(
        default=None,
        description="Id of the regions that GCS plans in; null for the newest that fit",
    )
    parameters: dict[Name, ParameterValue] = Field(
        default={},
        max_length=64,
        description="OMPL's names and values of its parameters; of several planners, each takes "
        "those that it has",
    )
    attempts: Annotated[int, Strict(), Field(ge=1, le=100), WHOLE] = Field(
        default=1,
        description="How many solutions to look for; the best by `objective` is kept. Of several "
        "planners each has at least one",
    )
    allowed_planning_time: Annotated[Real, Field(gt=0, le=3600)] = Field(
        default=5.0, description="For the whole plan, all stages [s]"
    )
    resolution: Annotated[Real, Field(ge=1e-4, le=10)] = Field(
        default=0.05,
        description="Largest joint-space distance between two checked states of an edge [rad or m]",
    )
    num_states: Annotated[int, Strict(), Field(ge=2, le=100_000), WHOLE] | None = Field(
        default=None, description="Interpolate the path to at least this many waypoints"
    )
    weights: dict[Name, Annotated[Real, Field(ge=1e-3, le=1e3)]] = Field(
        default={},
        max_length=256,
        description="Factors of the metric that planners measure by [1], by name of a joint or of "
        "one of the group's `blocks`; 1 for what is not named",
    )
    bounds: dict[Name, Interval] = Field(
        default={},
        max_length=256,
        description="Lowest and highest value to search in [rad or m], by position name, within "
        "the limits",
    )
    spaces: dict[Name, Literal["full", "position"] | CarWire] = Field(
        default={},
        max_length=64,
        description="`position` keeps the rotation of a planar or floating joint, named here, as "
        "it is at the start; a turning radius [m] makes a car of a planar joint",
    )
    solve_time: Annotated[Real, Field(gt=0, le=3600)] | None = Field(
        default=None,
        description="For the planner, in each attempt [s]; null for as long as there is",
    )
    shortcut_time: Annotated[Real, Field(ge=0, le=3600)] | None = Field(
        default=None,
        description="For shortening each solution [s]; 0 for none, null for a share of the rest",
    )
    objective: Literal["length", "weighted_length", "clearance", "duration"] = Field(
        default="length",
        description="By what solutions are compared, and improved by planners that improve them",
    )
    approximate: bool = Field(
        default=False,
        description="Whether a failure tells, as evidence `approximate`, the nearest configuration "
        "to a goal that was reached",
    )
    keep_graph: bool = Field(
        default=False, description="Whether the planner's graph is kept for GET /plans/{id}/graph"
    )
    on_cancel: Literal["discard", "best"] = Field(
        default="discard",
        description="What a cancel ends: the plan, or only the search if it has a path by then; "
        "that path is delivered if it can be timed and proven in 0.9 s",
    )
    approach_states: Annotated[int, Strict(), Field(ge=2, le=100_000), WHOLE] = Field(
        default=100,
        description="Interpolate each straight part to at least this many waypoints; `num_states` "
        "is then for the free part",
    )
    roadmap: RoadmapWire | None = Field(
        default=None,
        description="Look for a path in this roadmap first, and ask the planner only where it has "
        "none; not together with `path_constraints`",
    )


class RefineWire(Wire):
    """Whether and how to optimise the path."""

    method: Literal["trajopt", "auto", "none"] = Field(
        default="trajopt",
        description="Optimise the duration; do so only if at least half a second is left; or leave "
        "the path as it is",
    )


class RetimeWire(MotionLimits):
    """How to time the path."""

    method: Literal["toppra", "ruckig"] = Field(
        default="toppra",
        description="toppra keeps velocity and acceleration limits; ruckig keeps jerk limits too",
    )
    velocity_scale: Scale = Field(default=1.0, description="Factor on every velocity limit, 0..1")
    acceleration_scale: Scale = Field(
        default=1.0, description="Factor on every acceleration and jerk limit, 0..1"
    )
    sample_period: Annotated[Real, Field(ge=1e-3, le=10)] = Field(
        default=0.01, description="Of the delivered samples [s]"
    )
    num_points: Annotated[int, Strict(), Field(ge=2, le=200_000), WHOLE] | None = Field(
        default=None,
        description="Deliver so many samples, evenly in time, first and last instants included; "
        "null for one every `sample_period`",
    )
    duration: Annotated[Real, Field(gt=0, le=86_400)] | None = Field(
        default=None,
        description="How long the motion shall take [s]; null for the least that the limits allow, "
        "and less than that is `retiming_failed`",
    )
    explain: Annotated[bool, Strict()] = Field(
        default=False,
        description="Say which limit binds when, and what relaxing it would save "
        "(`stages.retime.explanation`); takes some 20 ms",
    )


class CertifyWire(Wire):
    """What to find out about the motion once it is proven; told in the report on `certify`."""

    stop_anywhere: Annotated[bool, Strict()] = Field(
        default=False,
        description="Bound the longest stop along the path, from any instant: a check `stop`, and "
        "`stop` in the report; takes some 0.1 s, 0.5 s with jerk limits",
    )
    max_stopping_time: Annotated[Real, Field(gt=0, le=86_400)] | None = Field(
        default=None,
        description="No stop may take longer [s], and `stop_anywhere` is meant; null for no bound",
    )
    robustness: Annotated[bool, Strict()] = Field(
        default=False,
        description="Bound how far off obstacles and joints may be: `robustness` in the report; "
        "takes some 0.2 s",
    )


class PlanRequest(Wire):
    """Move a group of a scene from a start to a goal."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    scene: Identifier = Field(description="Id of a scene")
    revision: Annotated[int, Strict(), Field(ge=1), WHOLE] | None = Field(
        default=None, description="Of the scene; null for its latest"
    )
    group: Name = Field(description="`robot` for its default group, or `robot::group`")
    start: Positions | None = Field(
        default=None,
        description="The group's positions [rad or m]; null for the scene's current state",
    )
    goal: GoalWire = Field(description="What to reach")
    path_constraints: Annotated[list[ConstraintWire], Field(max_length=64)] = Field(
        default=[],
        description="What the motion shall keep on its whole way, all of it; each has a check of "
        "its own in the certificate",
    )
    ik: IkWire = Field(default_factory=IkWire, description="Options of the goals stage")
    search: SearchWire = Field(default_factory=SearchWire, description="Options of the search")
    refine: RefineWire = Field(default_factory=RefineWire, description="Options of the refinement")
    retime: RetimeWire = Field(default_factory=RetimeWire, description="Options of the timing")
    certify: CertifyWire = Field(
        default_factory=CertifyWire, description="What to find out besides the proof"
    )
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="Of all randomness: the same seed gives the same bytes"
    )

    @model_validator(mode="after")
    def _know_no_constraints_in_roadmaps(self) -> Self:
        if self.search.roadmap is not None and self.path_constraints:
            message = "search.roadmap: roadmaps know no path_constraints; ask for one of the two"
            raise ValueError(message)
        return self
