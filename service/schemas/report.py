"""What every stage of a plan says about its work."""

from typing import Literal

from pydantic import Field

from service.schemas.wire import Answer


class PairTallyWire(Answer):
    """How often two bodies were the deepest collision of a rejected configuration."""

    bodies: tuple[str, str] = Field(description="Full names")
    count: int = Field(description="Rejected configurations")
    min_depth: float = Field(description="Smallest depth among them [m]")
    max_depth: float = Field(description="Largest depth among them [m]")


class LegTallyWire(Answer):
    """How often one thing stopped the approach or retreat of a configuration."""

    leg: str = Field(description="`approach` or `retreat`")
    reason: str = Field(description="`limit`, `singularity`, `collision` or `unreachable`")
    where: str = Field(description="The pair of bodies or the joint, or empty")
    count: int = Field(description="Configurations")
    max_fraction: float = Field(
        description="The most of the line that was free, seen from the goal [1]"
    )


class FunnelWire(Answer):
    """How many IK samples survived what; every number is at most the one before it."""

    tried: int = Field(description="Seeds given to the solver")
    converged: int = Field(description="Reached the target within tolerance")
    within_limits: int = Field(description="Kept the joint limits")
    collision_free: int = Field(description="Touch nothing")
    approach_ok: int = Field(
        default=0,
        description="Have a free, continuous approach and retreat; all of them if none is asked",
    )
    distinct: int = Field(description="Differ from all others")
    rejected_by: list[PairTallyWire] = Field(
        description="Which pairs the colliding ones hit, of the first few that were measured"
    )
    blocked_by: list[LegTallyWire] = Field(
        default=[], description="What stopped approaches and retreats, most frequent first"
    )
    violating: int = Field(
        default=0,
        description="Goal configurations, whole turns included, that were dropped because they or "
        "their lines violate a path constraint",
    )
    breaking: int = Field(
        default=0, description="Of the collision-free samples, those that violate a path constraint"
    )


class RejectionWire(Answer):
    """Why some samples are no goal configurations."""

    reason: Literal[
        "not_converged",
        "outside_limits",
        "collision",
        "path_constraint",
        "approach",
        "duplicate",
    ] = Field(description="What is wrong with them")
    count: int = Field(description="How many; with `distinct` the counts add up to `tried`")
    share: float = Field(description="Of `tried`, 0 to 1")
    bodies: tuple[str, str] | None = Field(
        description="For `collision`, what they hit deepest; null for those that time was short for"
    )
    min_depth: float | None = Field(description="Smallest depth among them [m]")
    max_depth: float | None = Field(description="Largest depth among them [m]")


class IkFunnelWire(FunnelWire):
    """The same, with the reason of every rejected sample."""

    rejected: list[RejectionWire] = Field(description="Why the others are no solutions")
    summary: str = Field(description="The same as a sentence")


class GoalsReportWire(Answer):
    """What the goals stage found."""

    num_configurations: int = Field(description="Goal configurations that were offered to search")
    funnel: FunnelWire = Field(description="How many samples survived what")


class AttemptReportWire(Answer):
    """What one attempt at a solution came to."""

    planner: str = Field(description="OMPL's name")
    outcome: str = Field(description="`solved`, `collides` (on a closer look), or how it ended")
    raw_length: float = Field(description="Of its solution, before shortcutting [rad or m]")
    length: float = Field(description="And after it [rad or m]")
    cost: float = Field(description="By the objective, in its unit")
    num_states_checked: int = Field(description="Configurations checked for collision")


class RegionsReportWire(Answer):
    """What regions were good for in a search."""

    digest: str = Field(description="Of the regions: with the same ones the plan is repeatable")
    num_regions: int = Field(description="How many there are")
    considered: list[int] = Field(description="Places of those that the path was looked for in")
    is_inside: bool = Field(description="Whether the path came from them")
    fallback: str = Field(description="Why it did not, or empty")


class RoadmapReportWire(Answer):
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
        "not_proven",
    ] = Field(
        description="Why not: a straight line is better, no free way leads from the start or to a "
        "goal, none through it, its path is blocked on a closer look, or was not proven; or empty"
    )


class SearchReportWire(Answer):
    """What the search stage did; lengths are in joint space [rad or m]."""

    planner: str = Field(
        description="OMPL's name; of several, whose solution was kept; `roadmap` for a roadmap's"
    )
    attempts: int = Field(description="Solutions asked for")
    solved: int = Field(description="Exact solutions found")
    num_states_checked: int = Field(description="Configurations checked for collision")
    num_motions_checked: int = Field(description="Edges checked")
    raw_length: float = Field(description="Of the kept solution, before shortcutting [rad or m]")
    length: float = Field(description="And after it [rad or m]")
    num_waypoints: int = Field(description="Of the delivered path")
    resolution: float = Field(description="At which edges were checked [rad or m]")
    padding: float = Field(description="Distance that was demanded beyond the margin [m]")
    direct: bool = Field(
        default=False, description="Whether the straight line was free, so that nobody searched"
    )
    objective: str = Field(default="length", description="By what solutions were compared")
    cost: float = Field(
        default=0.0,
        description="Of the kept solution: a length [rad or m], a duration [s], or, for clearance, "
        "length over distance",
    )
    attempts_log: list[AttemptReportWire] = Field(
        default=[], description="One entry per attempt, the first hundred"
    )
    was_canceled: bool = Field(default=False, description="Whether a cancel ended the search early")
    regions: RegionsReportWire | None = Field(
        default=None, description="What regions were good for, if the planner is GCS"
    )
    roadmap: RoadmapReportWire | None = Field(
        default=None, description="What a roadmap did, if one was asked for"
    )


class RefineReportWire(Answer):
    """What the refine stage did."""

    method: str = Field(description="`trajopt`, `auto` or `none`")
    improved: bool = Field(description="Whether the refined curve is what was delivered")
    reason: str = Field(description="Why not, or empty")
    solver: str = Field(description="Name of the solver, or empty")
    rounds: int = Field(description="Steps tried, each a convex program")
    length_before: float = Field(description="Of the path [rad or m]")
    length_after: float = Field(description="Of the refined curve [rad or m]")
    duration_before: float = Field(description="Estimate for the initial guess [s]")
    duration_after: float = Field(description="Estimate for the solution [s]")
    lower_bound: float = Field(
        description="What the slowest joint alone takes from start to goal [s]; nothing is quicker"
    )


class BindingIntervalWire(Answer):
    """What keeps the motion from being quicker for a while."""

    begin: float = Field(description="[s]")
    end: float = Field(description="[s]")
    limit: str = Field(
        description="velocity, acceleration, jerk, torque, tool_speed, tool_acceleration, "
        "speed_zone or acceleration_bounds; empty where none is used up"
    )
    where: str = Field(description="The joint, block, frame or zone whose limit it is, or empty")


class SavingWire(Answer):
    """How much shorter the motion would be with one limit relaxed."""

    limit: str = Field(description="Which, as in the intervals")
    where: str = Field(description="The joint, block, frame or zone whose limit it is")
    seconds: float = Field(description="How much shorter [s]")


class DurationExplanationWire(Answer):
    """Why the motion takes as long as it does."""

    intervals: list[BindingIntervalWire] = Field(
        description="What binds when; together they cover the motion"
    )
    relaxed: float = Field(description="The factor by which limits were relaxed, one at a time")
    savings: list[SavingWire] = Field(description="What that saved, the most first")


class RetimeReportWire(Answer):
    """What the retime stage did."""

    method: str = Field(description="`toppra` or `ruckig`")
    duration: float = Field(description="Of the trajectory [s]")
    slowed: float = Field(description="Factor by which the audit stretched it; 1 is not at all")
    binding: dict[str, str] = Field(description="What is nearest its bound, per limit")
    utilisation: dict[str, float] = Field(description="Peak over limit, per limit [1]")
    stops: int = Field(description="Instants of rest between start and goal")
    blend_deviation: float = Field(description="How far corners were rounded [rad or m]")
    explanation: DurationExplanationWire | None = Field(
        default=None, description="Why it takes that long, if that was asked for"
    )


class StopReportWire(Answer):
    """Stops along the path within limits, from every instant: guaranteed upper bounds."""

    time: float = Field(description="Of the longest stop [s]")
    begin: float = Field(description="When it begins [s]")
    distance: float = Field(description="A joint's longest way until it stands [rad or m]")
    joint: str = Field(description="Which joint, or block of a planar or floating one")
    tool_distance: float | None = Field(
        description="The tool frame's longest way until it stands [m]; null without a tool frame"
    )
    frame: str = Field(description="The tool frame, or empty")


class RobustnessWire(Answer):
    """What the proof of clearance survives: guaranteed lower bounds, each by itself."""

    obstacle_displacement: float = Field(
        description="How far all points of all obstacles may be from where the scene has them, at "
        "most 1 [m]"
    )
    obstacle_pair: tuple[str, str] = Field(description="The two bodies that allow no more")
    obstacle_time: float = Field(description="When they do [s]")
    joint_error: float = Field(
        description="How far off every joint may be at once, at most 0.5 [rad or m]"
    )
    joint_pair: tuple[str, str] = Field(description="The two bodies that allow no more")
    joint_time: float = Field(description="When they do [s]")


class CertifyReportWire(Answer):
    """What the certify stage did."""

    intervals: int = Field(description="Intervals on which clearance was bounded")
    distance_queries: int = Field(description="Configurations at which distances were measured")
    candidates: int = Field(description="Candidate motions that were looked at")
    refused: list[str] = Field(description="What was wrong with those before the delivered one")
    stop: StopReportWire | None = Field(
        default=None, description="How it can be stopped; null if nobody asked"
    )
    robustness: RobustnessWire | None = Field(
        default=None, description="How wrong world and robot may be; null if nobody asked"
    )


class StagesWire(Answer):
    """One report per stage."""

    goals: GoalsReportWire = Field(description="Goal configurations")
    search: SearchReportWire = Field(description="The path")
    refine: RefineReportWire = Field(description="The optimisation")
    retime: RetimeReportWire = Field(description="The timing")
    certify: CertifyReportWire = Field(description="The proof")
