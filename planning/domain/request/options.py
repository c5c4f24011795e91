"""Options of the stages, with their defaults; each stage reads its own and no other."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from planning.domain.request.motion_limits import AccelerationBounds, SpeedZone, ToolLimit
from planning.domain.robot.payload import Payload
from planning.domain.robot.steering import Steering
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PoseMetric(Value):
    """How far apart two poses are: sqrt((translation * t)^2 + (rotation * theta)^2).

    t is the distance of their origins [m], theta the angle between them [rad].

    Attributes:
        translation: Weight of a metre.
        rotation: Weight of a radian; by default one weighs as much as 0.1 m.
    """

    translation: float = 1.0
    rotation: float = 0.1


@dataclass(frozen=True, eq=False)
class IkOptions(Value):
    """How hard to look for goal configurations, and which of them are near.

    Attributes:
        max_configurations: So many at most, the nearest of those that are found: of goals of a tool
            frame as many are looked for, but 100 at least.
        max_trials: Stop after this many seeds of the solver, over all targets.
        joint_weights: Factor on each joint's part of the distance from the start, by full name;
            1 for joints that are not named.
        pose_metric: Which pose is the nearest to one that no configuration reaches.
        time_limit: For finding them, or saying why there is none [s]; None for as long as there is.
    """

    max_configurations: int = 100
    max_trials: int = 300
    joint_weights: Mapping[str, float] = field(default_factory=dict)
    pose_metric: PoseMetric = field(default_factory=PoseMetric)
    time_limit: float | None = None


@dataclass(frozen=True, eq=False)
class RoadmapOptions(Value):
    """A roadmap that many plans share.

    Attributes:
        states: How many free configurations it has, not counting those on ways that bend.
        neighbours: With how many of the nearest others each is joined, where the way is free.
        seed: Of its samples; a plan's own seed does not change it.
    """

    states: int = 2_000
    neighbours: int = 12
    seed: int = 0


@dataclass(frozen=True, eq=False)
class SearchOptions(Value):
    """How to search for a path.

    Attributes:
        planner: OMPL's name of the planner, or several names: they take turns. "GCS" plans inside
            the problem's regions, and where it cannot the others do, by default RRTConnect.
        parameters: OMPL's names and values of the planner's parameters; of several planners, each
            takes those that it has.
        attempts: How many solutions to look for; the best by the objective is kept. Of several
            planners each has at least one.
        allowed_planning_time: For the whole plan, all stages, from when it begins [s].
        resolution: Largest distance between two checked states of a motion (joint-space length:
            radians and metres weigh the same).
        num_states: If given, the path is interpolated to at least this many waypoints.
        weights: Factors of the metric that planners measure by, by name of a joint or of one of its
            blocks (`JointGroup.blocks`); 1 for what is not named.
        bounds: Lowest and highest value to search in [rad or m], by name of a position coordinate,
            within the limits. The later stages keep the limits, not these.
        spaces: What of a planar or floating joint is searched, by its name: "position" keeps its
            rotation as it is at the start; a `Steering` makes a car of a planar joint.
        setup_time: For all that comes before the planner's work in each attempt: the space, which
            attempts share, and the planner [s]; an attempt that took longer gives up. None for as
            long as it takes.
        solve_time: For the planner, in each attempt [s]; None for as long as there is.
        shortcut_time: For shortening each solution [s]; 0 for none, None for a share of what is
            left.
        interpolate_time: For interpolating each solution to `num_states` [s]; one that takes longer
            stays as it was, which the report says. None for as long as there is.
        objective: By what solutions are compared, and improved by planners that improve them.
        approximate: Whether a failure tells the nearest configuration to a goal that was reached.
        keep_graph: Whether the planner's graph is kept.
        on_cancel: What a cancel ends: the plan ("discard"), or only the search where it has a
            solution by then ("best").
        approach_states: Each straight line is interpolated to at least this many.
        roadmap: If given, paths are looked for in this roadmap first, and the planner is asked
            only where it has none.
    """

    planner: str | tuple[str, ...] = "RRTConnect"
    parameters: Mapping[str, str | float | int | bool] = field(default_factory=dict)
    attempts: int = 1
    allowed_planning_time: float = 5.0
    resolution: float = 0.05
    num_states: int | None = None
    weights: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    spaces: Mapping[str, Literal["full", "position"] | Steering] = field(default_factory=dict)
    setup_time: float | None = None
    solve_time: float | None = None
    shortcut_time: float | None = None
    interpolate_time: float | None = None
    objective: Literal["length", "weighted_length", "clearance", "duration"] = "length"
    approximate: bool = False
    keep_graph: bool = False
    on_cancel: Literal["discard", "best"] = "discard"
    approach_states: int = 100
    roadmap: RoadmapOptions | None = None

    @property
    def planners(self) -> tuple[str, ...]:
        """The names of the planners, however many."""
        return (self.planner,) if isinstance(self.planner, str) else tuple(self.planner)

    @property
    def num_attempts(self) -> int:
        """How many attempts there are, one for each planner at least."""
        return max(self.attempts, len(self.planners))


@dataclass(frozen=True, eq=False)
class ClearanceWish(Value):
    """Clearance that is wished for, beyond the margin that is demanded.

    Attributes:
        distance: Between bodies, but for those of one robot [m].
        weight: By how much longer a motion may take for a metre less of what its clearance lacks
            of the distance, on average along the motion [s/m].
    """

    distance: float
    weight: float


@dataclass(frozen=True, eq=False)
class RefineOptions(Value):
    """Whether and how to optimise the path.

    Attributes:
        method: "trajopt"; "auto", which optimises only where the time left allows for it; or
            "none".
        clearance: What the duration is weighed against; None for nothing.
    """

    method: Literal["none", "trajopt", "auto"] = "trajopt"
    clearance: ClearanceWish | None = None


@dataclass(frozen=True, eq=False)
class CertifyOptions(Value):
    """What to find out about a motion once it is proven; by default nothing.

    Attributes:
        stop_anywhere: Whether to bound the longest stop along the path, from any instant. Stops
            keep all limits that the motion keeps.
        max_stopping_time: No stop may take longer [s], which asks for their bound as well; None for
            as long as it takes.
        robustness: Whether to bound how far off obstacles and joints may be.
    """

    stop_anywhere: bool = False
    max_stopping_time: float | None = None
    robustness: bool = False

    @property
    def wants_stops(self) -> bool:
        """Whether stops are to be looked at."""
        return self.stop_anywhere or self.max_stopping_time is not None


@dataclass(frozen=True, eq=False)
class RetimeOptions(Value):
    """How to time the path.

    Attributes:
        method: "toppra" (velocity, acceleration) or "ruckig" (and jerk).
        velocity_scale: Factor on every velocity limit, in (0, 1].
        acceleration_scale: Factor on every acceleration and jerk limit, in (0, 1].
        sample_period: Of the delivered samples [s].
        duration: How long the motion shall take [s], no less than the least that the limits allow;
            None for that.
        deviation: How far from the path its corners may be rounded at most (joint-space length), 0
            to follow it exactly, with a rest at every corner; None for at most 0.1. What refinement
            makes of a path has no corners.
        explain: Whether to say which limit binds when, and what relaxing it would save, if there
            is time for that once the motion is proven.
        tool_limits: Of frames, besides the limits of joints, one a frame at most.
        speed_zones: Boxes in which frames are slower.
        acceleration_bounds: Besides the limits of joints, lowest (negative) and highest
            acceleration [rad/s^2 or m/s^2], by name of a scalar joint or of a block of one
            coordinate (`JointGroup.blocks`). The scales change none of these three.
        effort: Whether the limits on joint torques and forces are kept, and proven.
        payload: What the group carries that the scene does not show; it counts for efforts.
    """

    method: Literal["toppra", "ruckig"] = "toppra"
    velocity_scale: float = 1.0
    acceleration_scale: float = 1.0
    sample_period: float = 0.01
    duration: float | None = None
    deviation: float | None = None
    explain: bool = False
    tool_limits: tuple[ToolLimit, ...] = ()
    speed_zones: tuple[SpeedZone, ...] = ()
    acceleration_bounds: AccelerationBounds = field(default_factory=dict)
    effort: bool = False
    payload: Payload | None = None
