"""Options: settings of the pipeline's stages with their defaults; each stage reads only its own."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from planning.domain.request.drake_term import DrakeTerm
from planning.domain.request.motion_limits import AccelerationBounds, SpeedZone, ToolLimit
from planning.domain.request.refine_objective import RefineObjective
from planning.domain.robot.payload import Payload
from planning.domain.robot.steering import Steering
from planning.domain.value import Value

# Smallest factor on limits: with it a motion of three seconds takes a century.
MIN_SCALE = 1e-9


@dataclass(frozen=True, eq=False)
class PoseMetric(Value):
    """Distance between two poses: sqrt((translation * t)^2 + (rotation * theta)^2).

    t is the distance of their origins [m], theta the angle between them [rad].

    Attributes:
        translation: Weight of a metre.
        rotation: Weight of a radian; by default one radian weighs as much as 0.1 m.
    """

    translation: float = 1.0
    rotation: float = 0.1


@dataclass(frozen=True, eq=False)
class IkOptions(Value):
    """Options of the goals stage: effort of inverse kinematics, and the metric of solutions.

    Attributes:
        max_configurations: Largest number of goal configurations, the nearest to the start; goals
            of a tool frame search for as many, but for 100 at least.
        max_trials: Stop after this many seeds of the solver, over all targets.
        joint_weights: Factor on each joint's part of the distance from the start, by full name;
            1 for joints that are not named.
        pose_metric: Metric for the nearest pose to an unreachable one.
        allowed_time: For inverse kinematics, and for the diagnosis if there is no solution [s];
            None for no limit.
    """

    max_configurations: int = 100
    max_trials: int = 300
    joint_weights: Mapping[str, float] = field(default_factory=dict)
    pose_metric: PoseMetric = field(default_factory=PoseMetric)
    allowed_time: float | None = None


@dataclass(frozen=True, eq=False)
class RoadmapOptions(Value):
    """Options of a probabilistic roadmap that many plans share.

    Attributes:
        states: Number of free configurations, not counting intermediate states of curved edges.
        neighbours: Number of nearest neighbours that each state is connected to, where the edge is
            free.
        seed: Of its samples; a plan's own seed does not change it.
    """

    states: int = 2_000
    neighbours: int = 12
    seed: int = 0


@dataclass(frozen=True, eq=False)
class SearchOptions(Value):
    """Options of the search stage: planner, metric, bounds, time limits and objective.

    Attributes:
        planner: OMPL's name of the planner, or several names, which alternate. "GCS" plans inside
            the problem's convex regions; where it cannot, the other planners do, by default
            RRTConnect.
        parameters: OMPL's names and values of the planner's parameters; of several planners, each
            takes those that it has.
        attempts: Number of solutions to search for; the best by the objective is kept. Of several
            planners each has at least one.
        allowed_planning_time: For the whole plan, all stages, from when it begins [s].
        resolution: Largest distance between two checked states of a motion (joint-space length:
            radians and metres weigh the same).
        num_states: If given, the path is interpolated to at least this many waypoints.
        weights: Factors of the planners' metric, by name of a joint or of one of its blocks
            (`JointGroup.blocks`); 1 for what is not named.
        bounds: Lowest and highest value of the search space [rad or m], by name of a position
            coordinate, within the limits. The later stages keep the limits, not these.
        spaces: State space of a planar or floating joint, by its name: "position" fixes its
            rotation to that of the start; a `Steering` makes a planar joint a car.
        setup_time: For all work before the planner runs in each attempt: the space, which
            attempts share, and the planner [s]; an attempt that takes longer gives up. None for no
            limit.
        solve_time: For the planner, in each attempt [s]; None for no limit but the deadline.
        shortcut_time: For shortcutting each solution [s]; 0 for none, None for a share of the
            remaining time.
        interpolate_time: For interpolating each solution to `num_states` [s]; a solution that takes
            longer stays as it was, which the report says. None for no limit.
        objective: Path cost that compares solutions, and that optimizing planners minimize.
        approximate: Whether a failure reports the reached configuration nearest to a goal.
        keep_graph: Whether the planner's graph is kept.
        on_cancel: Effect of a cancel: it ends the plan ("discard"), or only the search if that has
            a solution by then ("best").
        approach_states: Each linear move is interpolated to at least this many states.
        roadmap: If given, this roadmap is queried first, and the planner runs only if the roadmap
            has no path.
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
        """Names of the planners, one or several."""
        return (self.planner,) if isinstance(self.planner, str) else tuple(self.planner)

    @property
    def num_attempts(self) -> int:
        """Number of attempts, at least one for each planner."""
        return max(self.attempts, len(self.planners))


@dataclass(frozen=True, eq=False)
class ClearanceObjective(Value):
    """Clearance objective: preferred clearance beyond the collision margin, as a soft cost.

    Attributes:
        distance: Preferred clearance between bodies, except between those of one robot [m].
        weight: Cost of missing clearance, averaged along the motion, in seconds of duration per
            metre [s/m].
    """

    distance: float
    weight: float


@dataclass(frozen=True, eq=False)
class RefineOptions(Value):
    """Options of the refine stage: path optimization.

    Attributes:
        method: "trajopt", by convex steps; "drake", by Drake's kinematic trajectory optimization;
            "auto", which is "trajopt" where the remaining time allows for it; or "none".
        clearance: Clearance objective that is weighed against the duration, for "trajopt" and
            "auto"; None for none.
        objective: What is minimized; None for the duration.
        terms: Costs and constraints that are added to Drake's program, for "drake".
    """

    method: Literal["none", "trajopt", "auto", "drake"] = "trajopt"
    clearance: ClearanceObjective | None = None
    objective: RefineObjective | None = None
    terms: tuple[DrakeTerm, ...] = ()

    @property
    def reports_objectives(self) -> bool:
        """Whether the report has the values of all objectives."""
        return self.objective is not None or self.method == "drake"


@dataclass(frozen=True, eq=False)
class CertifyOptions(Value):
    """Options of the certify stage: properties of a proven motion to bound; by default none.

    Attributes:
        stop_anywhere: Whether to bound the longest stop along the path, from any instant. Stops
            keep all limits that the motion keeps.
        max_stopping_time: Largest permitted stopping time [s]; it implies `stop_anywhere`. None for
            no limit.
        robustness: Whether to bound the tolerated obstacle displacement and joint error.
    """

    stop_anywhere: bool = False
    max_stopping_time: float | None = None
    robustness: bool = False

    @property
    def bounds_stops(self) -> bool:
        """Whether the certify stage bounds stops."""
        return self.stop_anywhere or self.max_stopping_time is not None


@dataclass(frozen=True, eq=False)
class RetimeOptions(Value):
    """Options of the retime stage: time parametrization of the path.

    Attributes:
        method: "toppra" (velocity, acceleration) or "ruckig" (and jerk).
        velocity_scale: Factor on every velocity limit, from `MIN_SCALE` to 1.
        acceleration_scale: Factor on every acceleration and jerk limit, likewise.
        sample_period: Of the delivered samples [s].
        duration: Requested duration [s], no less than the minimum under the limits; None for that
            minimum.
        deviation: Largest deviation from the path when its corners are rounded (joint-space
            length); 0 follows it exactly, with a rest at every corner; None for at most 0.1. A
            refined path has no corners.
        explain: Whether to report which limit is active when, and the time saved by relaxing it, if
            there is time for that once the motion is proven.
        tool_limits: Cartesian limits of frames, besides the joint limits; at most one per frame.
        speed_zones: Boxes with lower speed limits for frames.
        acceleration_bounds: Signed bounds besides the joint limits, lowest (negative) and highest
            acceleration [rad/s^2 or m/s^2], by name of a scalar joint or of a block of one
            coordinate (`JointGroup.blocks`). The scales change none of these three.
        effort: Whether the limits on joint torques and forces are kept, and proven.
        payload: Mass carried by the group that the scene does not contain; it counts for efforts.
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

    @property
    def limits_jerk(self) -> bool:
        """Whether the method keeps jerk limits, so that acceleration has no jumps."""
        return self.method == "ruckig"
