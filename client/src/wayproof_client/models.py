"""What a server answers. Made by `python -m client.generator`: never edit it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field, Json

from wayproof_client.answer import Answer
from wayproof_client.shown_plan import ShownPlan


class AddressEvidence(Answer):
    """Address that a webhook may not lead to."""

    host: str
    """Host in the URL."""
    pointer: str
    """JSON pointer to the URL in the body."""


class AddressNotAllowedProblem(Answer):
    """A webhook leads where the server sends nothing."""

    code: Literal["address_not_allowed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: AddressEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


type AnyLimit = (
    Literal[
        "velocity",
        "acceleration",
        "jerk",
        "torque",
        "tool_speed",
        "tool_acceleration",
        "speed_zone",
        "acceleration_bounds",
        "duration",
        "",
    ]
    | str
)
"""Limit that keeps a motion from being quicker."""

type AnyStage = (
    Literal[
        "load",
        "goals",
        "line",
        "roadmap",
        "search",
        "refine",
        "retime",
        "schedule",
        "certify",
        "explain",
        "samples",
        "regions",
        "execute",
        "",
        "plan",
        "worker",
    ]
    | str
)
"""Stages of jobs, and what stands for none."""


class ApproachBlockedFailure(Answer):
    """No free goal configuration has a free approach and retreat."""

    code: Literal["approach_blocked"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class ApproachBlockedProblem(Answer):
    """No free goal configuration has a free approach and retreat."""

    code: Literal["approach_blocked"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class ApproachFailures(Answer):
    """Configurations whose approach or retreat one cause stopped."""

    count: int
    """Number of configurations."""
    leg: LineLeg
    """Line that was stopped, the approach or the retreat."""
    max_fraction: float
    """Largest share of the line that was free, from the goal outwards, 0 to 1 [1]."""
    reason: LineStopReason
    """Reason why they stopped."""
    where: str
    """Pair of bodies or joint that stopped them, or empty."""


class Approximation(Answer):
    """The nearest that a search came to a goal."""

    goal: list[float]
    """The goal configuration that it is nearest to [rad or m]."""
    goal_distance: float
    """Distance from that configuration to the goal, as a length in joint space [rad or m]."""
    path: list[list[float]]
    """Path to that configuration, one row per waypoint [rad or m]."""
    positions: list[float]
    """Configuration of the search that is nearest to a goal [rad or m]."""


class AssetEvidence(Answer):
    """File that does not exist."""

    uri: str
    """Name of the file in the scene or in the model."""
    known: list[str] | None = None
    """Names that exist."""
    path: str | None = None
    """Place of the name in the scene."""


class AssetNotFoundFailure(Answer):
    """A robot description, mesh or package does not exist."""

    code: Literal["asset_not_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: AssetEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class AssetNotFoundProblem(Answer):
    """A robot description, mesh or package does not exist."""

    code: Literal["asset_not_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: AssetEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class AttachmentDocument(Answer):
    """Attachment of an object to a robot."""

    frame: str
    """Frame that the object follows: `robot::link`, or a frame with one as ancestor."""
    grip: GripDocument | None = None
    """Contact that holds it; none for a weld. Plans and proofs take it to be welded either way,
    and a simulated robot may lose what is held by contact."""
    touch: list[str] | None = None
    """Bodies that it may touch; by default those that move rigidly with the frame and those
    that they carry outside the robot's default group, such as fingers."""


type AttemptOutcome = (
    Literal[
        "solved",
        "collides",
        "setup",
        "improving",
        "Approximate solution",
        "Exact solution",
        "Timeout",
        "Invalid start",
        "Invalid goal",
        "Unrecognized goal type",
        "Crash",
        "Unknown status",
    ]
    | str
)
"""Outcomes of a search's tries."""


class AttemptReport(Answer):
    """Outcome of one attempt at a solution."""

    cost: float
    """Cost by the objective, in its unit."""
    length: float
    """Length of its solution, after shortcutting [rad or m]."""
    num_states_checked: int
    """Configurations checked for collision."""
    outcome: AttemptOutcome
    """`solved`, `collides` (on a closer look), `setup` (setting the planner up took longer than
    it may), or how it ended."""
    planner: str
    """Name of the planner in OMPL."""
    raw_length: float
    """Length of its solution, before shortcutting [rad or m]."""


class Batch(Answer):
    """A batch; poll it until `finished_at` is there. Deleted plans are no part of it any more."""

    counts: BatchCounts
    """Plans by state."""
    created_at: datetime
    """Time of the request (UTC)."""
    finished_at: datetime | None
    """Time at which the last plan ended (UTC); null while one waits or runs."""
    id: str
    """Id of the batch."""
    plans: list[str]
    """Ids of the plans, in the order of the problems; `GET /v1/plans?batch=` lists them, newest
    first."""


class BatchCounts(Answer):
    """Number of plans of a batch in each state."""

    canceled: int = 0
    """Plans whose end was requested."""
    failed: int = 0
    """Plans with a failure."""
    queued: int = 0
    """Plans that wait."""
    running: int = 0
    """Plans that a worker has."""
    succeeded: int = 0
    """Plans with a result."""


class BatchPage(Answer):
    """Batches, newest first."""

    items: list[BatchSummary]
    """Batches on this page, without the ids of their plans."""
    next: str | None
    """Cursor of the next page; null on the last one."""


class BatchSummary(Answer):
    """A batch without the ids of its plans. Deleted plans are no part of it any more."""

    counts: BatchCounts
    """Plans by state."""
    created_at: datetime
    """Time of the request (UTC)."""
    finished_at: datetime | None
    """Time at which the last plan ended (UTC); null while one waits or runs."""
    id: str
    """Id of the batch."""


class BestPath(Answer):
    """The best path that a search has found so far."""

    length: float
    """Weighted length of the path."""
    seconds: float | None = None
    """Time at which it was found, since the worker began with the plan [s]."""
    waypoints: list[list[float]] | None = None
    """Configurations along the path from the start to a goal, at most 64 of its waypoints; to
    look at, not to move along: nothing is proven of it, and a path that is still improved is
    checked coarsely. Null where the planner tells the length only."""


class BestPathData(Answer):
    """A path that is better than those before it."""

    at: datetime
    """Time at which it happened (UTC)."""
    detail: str
    """Text for a person."""
    length: float
    """Weighted length of the path."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""
    seconds: float | None = None
    """Time since the worker began with the plan [s]; null where an older version told it."""
    waypoints: list[list[float]] | None = None
    """Configurations along the path from the start to a goal, at most 64 of its waypoints; to
    look at, not to move along: nothing is proven of it, and a path that is still improved is
    checked coarsely. Null where the planner tells the length only."""


class BestSoFarEvent(Answer):
    """The search found a better path."""

    data: Json[BestPathData]
    """The better path."""
    event: Literal["best-so-far"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class BindingInterval(Answer):
    """Interval of the motion, with the limit that keeps it from being quicker."""

    begin: float
    """First instant [s]."""
    end: float
    """Last instant [s]."""
    limit: AnyLimit
    """Limit that is used the most: velocity, acceleration, jerk, torque, tool_speed,
    tool_acceleration, speed_zone or acceleration_bounds. It is `duration` where the request
    asks for a longer motion than it must be, and empty while nothing moves."""
    share: float
    """Largest share of the limit that is used, 0 to 1; 1 where it is met [1]."""
    where: str
    """The joint, block, frame or zone whose limit it is, or empty."""


class BlockedMoves(Answer):
    """Number of approaches or retreats that stopped for one reason."""

    count: int
    """Number of configurations."""
    leg: LineLeg
    """`approach` or `retreat`."""
    max_fraction: float
    """The largest part of the line that is free, from the goal outwards [0 to 1]."""
    reason: LineStopReason
    """Reason why they stopped."""
    where: str
    """Pair of bodies or joint that stopped them, or empty."""


class BodyTooLargeProblem(Answer):
    """The body has more bytes than are read."""

    code: Literal["body_too_large"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: SizeEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Bounds(Answer):
    """Bounds on the coordinates of a quantity; a block is limited by its norm."""

    lower: list[float | None]
    """Bound per coordinate; null for none."""
    upper: list[float | None]
    """Bound per coordinate; null for none."""


class Box(Answer):
    """A box, placed by the pose of its middle."""

    size: list[float]
    """Full side lengths along the axes of `pose` [m]."""
    pose: Pose | None = None
    """Pose of its middle; in a frame that moves with the group, as the start puts it."""


class Branch(Answer):
    """Sides to which a six-joint arm bends; one changes only at its singularity, where it is 0."""

    elbow: Literal[-1, 0, 1] | str
    """Side to which the elbow bends."""
    shoulder: Literal[-1, 0, 1] | str
    """Side of the first axis on which the wrist is."""
    wrist: Literal[-1, 0, 1] | str
    """Side to which the wrist bends."""


class BusyEvidence(Answer):
    """Execution that moves a robot, or waits for it."""

    execution: str
    """Id of the execution."""
    group: str
    """Group that it moves."""


class CancelEvidence(Answer):
    """Place of a cancel."""

    during: str | None = None
    """Work during which the cancel came."""
    reason: str | None = None
    """Reason why the server ended it; absent if a client did."""
    time: float | None = None
    """Time along the motion of an execution [s]."""


class CanceledFailure(Answer):
    """The caller canceled this plan."""

    code: Literal["canceled"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: CancelEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class CanceledProblem(Answer):
    """The caller canceled this plan."""

    code: Literal["canceled"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: CancelEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Car(Answer):
    """A planar base that moves like a car: never sideways, in no tighter turn than it can."""

    turning_radius: float
    """Radius of its tightest turn, at the origin of the base [m]."""
    reverse: bool = True
    """Whether it drives backwards too (Reeds and Shepp's curves) or not (Dubins')."""


class Certificate(Answer):
    """The verdict on the motion, between its samples too."""

    checks: list[Check]
    """All checks, passed or not."""
    min_clearance: float | None
    """Proven lower bound on the distance of all pairs at all instants [m]; `observed_clearance`
    if clearance is not proven; null if there is no pair."""
    pair: tuple[str, str]
    """The two bodies of `observed_clearance`, or empty names."""
    proven: bool
    """Whether every check passed on the whole interval."""
    time: float
    """Time at which it was observed [s]. If clearance is not proven, it is neither the first
    instant that is too near nor for certain the worst."""
    first_unproven: Pair | None = None
    """The pair that stopped the proof of clearance there, at most 0.1 ms later; null if none
    did."""
    observed_clearance: float | None = None
    """Smallest signed distance at any instant that was measured [m]; the true smallest one lies
    between `min_clearance`, if that is proven, and this."""
    points: list[list[float]] = Field(default=[], validate_default=True)
    """Nearest point of each body of `pair` at that time, in world [m]; the deepest points where
    they overlap, empty without a pair."""
    proven_until: float = 0.0
    """Clearance is proven from the beginning until then [s]: the duration, if the check
    `clearance` passed."""
    unchecked: list[UncheckedPair] = Field(default=[], validate_default=True)
    """Pairs of bodies whose clearance is not looked at, and why: the certificate says nothing
    of them."""


class CertificateEvidence(Answer):
    """Why no motion passed the certifier; of executions, why the plan's does not by now."""

    checks: list[FailedCheck]
    """Failed checks of the last motion, the worst first."""
    bound: float | None = None
    """Bound of that check; executions only."""
    check: str | None = None
    """Name of the first failed check; executions only."""
    execution: str | None = None
    """Id of the execution whose motion is in the way, if the check is `beside`."""
    other_time: float | None = None
    """Time on the motion of that execution [s], if the check is `beside`."""
    pair: list[str] | None = None
    """The two bodies that come too near, if that is the check; executions only."""
    refused: list[str] | None = None
    """Each motion that was refused, and why."""
    time: float | None = None
    """Time on the motion of the first failed check [s]; executions only."""
    value: float | None = None
    """Worst value of that check; executions only."""


class Certify(Answer):
    """Computations on the motion once it is proven; the report on `certify` has their results."""

    max_stopping_time: float | None = None
    """Longest time that a stop may take [s]; it implies `stop_anywhere`; null for no bound."""
    robustness: bool = False
    """Whether to bound how far off obstacles and joints may be: `robustness` in the report;
    takes about 0.2 s."""
    stop_anywhere: bool = False
    """Whether to bound the longest stop along the path, from any instant: a check `stop`, and
    `stop` in the report. It takes about 0.1 s, 0.5 s with jerk limits, and as much again with
    `effort` or accelerations in `tool_limits`."""


class CertifyMotionResponse(Answer):
    """The verdict on the motion, between its samples too."""

    certificate: Certificate
    """Checks that passed and checks that failed."""
    duration: float
    """Duration of the motion [s]."""
    interpolation: MotionInterpolation
    """Motion that was taken to be between the samples."""
    stage: CertifyReport
    """Report of the proof."""
    unchecked: list[str] = Field(default=[], validate_default=True)
    """Checks that straight lines are not held to, as their velocity jumps."""


class CertifyReport(Answer):
    """Report of the certify stage."""

    candidates: int
    """Candidate motions that were looked at."""
    distance_queries: int
    """Configurations at which distances were measured."""
    intervals: int
    """Intervals on which clearance was bounded."""
    refused: list[str]
    """Faults of the candidates before the delivered one."""
    robustness: Robustness | None = None
    """Bounds on how far off obstacles and joints may be; null if not requested, or no time was
    left."""
    stop: StopReport | None = None
    """Bounds on stops along the path; null if not requested, or no time was left."""


class Check(Answer):
    """One property that was checked on the whole interval."""

    bound: float | None
    """Bound that it was held against, in `unit`; null for none."""
    name: str
    """Name of the check: position, velocity, acceleration, jerk, clearance, start, ..."""
    passed: bool
    """Whether the property holds."""
    resolution: float | None
    """Bound on how far the true worst value may lie beyond `value`, in `unit`; null if there is
    none, for example where a search for it ended at once."""
    time: float
    """Time of the worst value [s]; not the first instant at which a check fails."""
    unit: CheckUnit
    """Unit of value, bound and resolution; `1` for peak over limit."""
    value: float | None
    """Worst value that was found, in `unit`; null for none. A check that failed may have worse
    values."""
    where: str
    """The joint or pair that is worst, or empty."""


class CheckResponse(Answer):
    """A verdict per configuration, in order."""

    results: list[Verdict]
    """Verdicts in the order of the configurations."""


type CheckUnit = (
    Literal["1", "rad or m", "rad/s or m/s", "rad", "m", "m/s", "m/s^2", "s", "faults"] | str
)
"""Units of checks."""


class ClearanceObjective(Answer):
    """Clearance that is preferred, beyond the margin that is required."""

    distance: float
    """Preferred distance between bodies, except between those of one robot [m]."""
    weight: float
    """Extra duration that one metre less of shortfall is worth [s/m]; the shortfall is what the
    clearance lacks of `distance`, on average along the motion."""


class CollidingPair(Answer):
    """Two bodies that were the deepest collision of rejected configurations."""

    bodies: tuple[str, str]
    """Full names of the bodies."""
    count: int
    """Number of rejected configurations."""
    max_depth: float
    """Largest depth among them [m]."""
    min_depth: float
    """Smallest depth among them [m]."""


class ConfigurationDocument(Answer):
    """A named configuration of a group."""

    group: str
    """`robot`, `robot::group`, or a group of `groups`."""
    positions: list[float]
    """Positions in the group's order [rad or m]."""


class ConfigurationGoal(Answer):
    """Reach a configuration that the scene or the robot names."""

    name: str
    """Name of the configuration, for example `home`."""
    type: Literal["configuration"]
    """Kind of goal."""


class ConfigurationRelaxation(Answer):
    """All changes that the least infeasible of the goal's configurations needs."""

    constraints: list[ConstraintViolation]
    """Path constraints that are violated."""
    goal_index: int
    """Index of the goal's configuration, from 0."""
    limits: list[ViolatedLimit]
    """Limits that are violated."""
    margin: float | None
    """A margin that is kept [m]; null where none is."""
    obstacles: list[ViolatingPair]
    """Pairs that are violated."""
    positions: list[float]
    """The group's positions [rad or m]."""
    remove: list[str] | None
    """Bodies to be removed; null where the robot is in its own way."""


class OtherConstraint(Answer):
    """One that a newer server has."""

    type: str


type Constraint = Annotated[
    Annotated[
        DistanceBand | KeepOut | KeepIn | Position | Orientation | LockedJoints | JointLimits,
        Field(discriminator="type"),
    ]
    | OtherConstraint,
    Field(union_mode="left_to_right"),
]
"""Constraint on a whole motion."""


class ConstraintViolation(Answer):
    """A path constraint that is violated."""

    bound: float | None
    """Bound of the constraint, in `unit`."""
    constraint: str
    """Place of the constraint in the request and its kind."""
    unit: str
    """Unit of value and bound; `1` for a number without one."""
    value: float | None
    """Value of the constraint, in `unit`."""
    joint: str | None = None
    """Worst joint, for constraints on joints."""


class Contact(Answer):
    """Two bodies that touched during the motion."""

    bodies: tuple[str, str]
    """Full names."""
    depth: float
    """Largest depth of penetration [m]."""
    time: float
    """Time along the motion of the first touch [s]."""
    force: float | None = None
    """Largest force between them [N]; null if it is not known."""


class ContactEvidence(Answer):
    """Bodies that touched."""

    pair: list[str]
    """Full names of both bodies."""
    time: float
    """Time along the motion [s]."""
    depth: float | None = None
    """Depth by which they overlap [m]."""
    execution: str | None = None
    """Id of the execution that moves the other robot, if one does."""
    force: float | None = None
    """Force between them [N]; null where it is not known."""


class ContactFailure(Answer):
    """The robot touched something."""

    code: Literal["contact"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: ContactEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class ControlsData(Answer):
    """Controls of an execution from now on; those that are left out stay as they were."""

    at: datetime
    """Time at which it happened (UTC)."""
    is_paused: bool | None = None
    """Whether it rests on its path."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""
    speed: float | None = None
    """Seconds of the motion per second; negative is backwards."""


class ControlsEvent(Answer):
    """The execution was paused or resumed, or its speed set."""

    data: Json[ControlsData]
    """The new controls."""
    event: Literal["controls"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class ConvexDocument(Answer):
    """The convex hull of points."""

    points: list[list[float]]
    """Points [m]; not all in one plane."""


class CountEvidence(Answer):
    """Number of values that a list should have."""

    expected: int
    """Number of values that are expected."""
    got: int
    """Number of values that were given."""
    names: list[str]
    """Names of the coordinates that the values are for."""
    field: str | None = None
    """Place of the list in the request."""


class CountedViolation(Answer):
    """Number of goal configurations that violate one path constraint."""

    constraint: str
    """Its place in the request and its kind."""
    count: int
    """Goal configurations."""
    least: ConstraintViolation
    """The least violation among them."""


type CutStage = (
    Literal[
        "load",
        "goals",
        "line",
        "roadmap",
        "search",
        "refine",
        "retime",
        "schedule",
        "certify",
        "explain",
        "samples",
        "regions",
        "execute",
        "shortcut",
        "interpolate",
    ]
    | str
)
"""Stages that a deadline may cut short."""


class DatabaseTakenEvidence(Answer):
    """Server that has the database."""

    epoch: int
    """Epoch of this server."""
    latest: int | None
    """Epoch of the server that has the database now."""


class DatabaseTakenProblem(Answer):
    """Another server has taken the database over."""

    code: Literal["database_taken"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: DatabaseTakenEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class DatabaseUnavailableProblem(Answer):
    """The database does not answer, or takes nothing."""

    code: Literal["database_unavailable"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: StorageEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class DeadlineEvidence(Answer):
    """Work that was done when the time was over; of a search, as in `SearchEvidence`."""

    allowed: float | None = None
    """Time that was allowed [s]."""
    approximate: Approximation | None = None
    """In the stage `search`, the nearest configuration to a goal, if the request wants it."""
    attempts: int | None = None
    """In the stage `search`, number of attempts."""
    cut_short: bool | None = None
    """In the stage `goals`, that the funnel is not complete."""
    during: str | None = None
    """Work during which the time ran out."""
    funnel: FunnelEvidence | None = None
    """In the stage `goals`, number of samples that passed each test until then."""
    goal_distance: float | None = None
    """In the stage `search`, distance from the nearest configuration to a goal, as a length in
    joint space [rad or m]."""
    grace: float | None = None
    """Time beyond it after which a worker that had not ended was ended [s]."""
    graph: dict[str, Any] | None = None
    """In the stage `search`, graph that the planner explored, if the request wants it."""
    max_trials: int | None = None
    """In the stage `goals`, number of samples to be tried."""
    num_edges: int | None = None
    """In the stage `search`, number of motions that the planner kept; null where it does not
    tell."""
    num_goals: int | None = None
    """In the stage `search`, number of goal configurations."""
    num_states_checked: int | None = None
    """In the stage `search`, number of configurations checked for collision."""
    num_vertices: int | None = None
    """In the stage `search`, number of configurations that the planner kept; null where it does
    not tell."""
    planner: str | None = None
    """In the stage `search`, name of the planner in OMPL; of several, all names."""
    waited: float | None = None
    """Time that the question waited for a worker before [s]."""


class DeadlineExceededFailure(Answer):
    """The allowed time ran out in the stage that was running."""

    code: Literal["deadline_exceeded"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: DeadlineEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class DeadlineExceededProblem(Answer):
    """The allowed time ran out in the stage that was running."""

    code: Literal["deadline_exceeded"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: DeadlineEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Deviation(Answer):
    """Deviation of a tool from its line that is allowed, between waypoints and samples too."""

    position: float = 0.001
    """Distance of the tool's origin from the line [m]."""
    rotation: float = 0.008726646259971648
    """Angle between the tool's rotation and that of the line [rad]."""


class DigestEvidence(Answer):
    """Scene that is not kept."""

    digest: str
    """Digest of the content of the scene."""


class DiskFullProblem(Answer):
    """The data folder has no room for what the request needs."""

    code: Literal["disk_full"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: StorageEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Displacement(Answer):
    """A displacement: a translation, a rotation, or both."""

    position: list[float] | None = None
    """Translation [m]; null for none."""
    quaternion: list[float] | None = None
    """Rotation as [w, x, y, z]; normalised when read, never zero."""
    rpy: list[float] | None = None
    """Rotation as roll, pitch, yaw about fixed x, y, z [rad]."""


class DistanceBand(Answer):
    """The smallest distance between two sets of bodies stays within bounds."""

    type: Literal["distance_band"]
    """Kind of constraint."""
    bodies: list[str] | None = None
    """Full names of the first set of bodies; null for all bodies that the group moves."""
    max: float | None = None
    """Largest value of the smallest distance [m]; null for no bound."""
    min: float = 0.0
    """Least distance that any two of them keep [m]."""
    to: list[str] | None = None
    """Full names of the second set of bodies; null for all not in `bodies`."""


class DocumentFault(Answer):
    """One fault of a document or of a parameter."""

    message: str
    """What is wrong there, for a person."""
    path: str
    """Place of the fault, as names and numbers with dots."""
    pointer: str
    """Place of the fault as a JSON pointer (RFC 6901); empty for the root and for parameters."""
    line: int | None = None
    """Line in the text, from 1; null where it is not known."""
    nearest: list[str] | None = None
    """Names or values that were perhaps meant, the nearest first."""
    parameter: str | None = None
    """Name of the parameter of the query, the path or the headers; absent for the body."""
    type: str | None = None
    """Kind of the fault, as the library calls it that checks documents."""


class DocumentSource(Answer):
    """The scene's document has the robot there."""

    revision: int
    """Revision of the document: the latest."""
    type: Literal["document"]
    """Kind of source."""


class DriverLostEvidence(Answer):
    """Driver that was lost, and what is known of its robot."""

    driver: str
    """Name of the driver."""
    reason: str
    """Reason of the loss."""
    rests: bool
    """Whether the robot is known to rest where it was last measured."""


class DriverLostFailure(Answer):
    """The robot does not answer, or no longer obeys."""

    code: Literal["driver_lost"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: DriverLostEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


type DriverName = Literal["simulated", "kinematic"] | str
"""Driver of a motion: `simulated` is Drake's simulation under a joint controller; `kinematic`
is a robot without mass that is always where it should be, and feels nothing."""


class DurationExplanation(Answer):
    """Why the motion takes as long as it does."""

    intervals: list[BindingInterval]
    """Intervals with the limit that binds in each; together they cover the motion."""
    relaxed: float
    """The factor by which limits were relaxed, one at a time."""
    savings: list[Saving]
    """Time that this saved, the most first; measured for limits that are met."""


class EditSource(Answer):
    """The robot was put there by hand, by `set_positions`."""

    revision: int
    """Revision that the edit made."""
    type: Literal["edit"]
    """Kind of source."""


class EditedScene(Answer):
    """A scene after an edit, and what that means for the motions that are carried out in it."""

    assumed: list[str]
    """Joints whose rate limits are assumed, because no source states them."""
    bodies: list[str]
    """Everything that can collide."""
    created_at: datetime
    """Time at which this revision was made (UTC)."""
    digest: str
    """sha256 of the content, the bytes of all files included."""
    document: SceneDocument
    """Document as it was posted or edited, defaults filled in."""
    executions: list[ExecutionVerdict]
    """Each execution that waits or moves in the scene, and whether what is left of its motion
    is proven in this revision."""
    frames: list[str]
    """Frames that poses may be given in."""
    groups: list[Group]
    """Groups that can be planned for."""
    id: str
    """Id of the scene."""
    name: str
    """Name for people."""
    num_pairs: int
    """Pairs of bodies that are kept apart."""
    revision: int
    """Revision of its content, from 1."""
    warnings: list[str]
    """Oddities of the scene, for example concave meshes."""
    files: dict[str, Files] = Field(default={}, validate_default=True)
    """Files that its robots and meshes were made from, by name. They are kept: no change of a
    file on the disk changes this scene."""
    unchecked: list[UncheckedPair] = Field(default=[], validate_default=True)
    """Pairs of bodies that no collision check looks at, and why."""


class EmptyDocument(Answer):
    """No parameters."""


class Encounter(Answer):
    """Two motions that would meet."""

    distance: float
    """Distance of both bodies then, negative where they overlap [m]."""
    pair: list[str]
    """The two bodies."""
    times: dict[str, float]
    """Time of the encounter on each group's own motion [s]."""
    waiting: str | None = None
    """Group that does not avoid the encounter, however long it waits."""


class EntityTagEvidence(Answer):
    """Revision that the scene is at."""

    asked: str
    """Tag in `If-Match`."""
    etag: str
    """`ETag` of the latest revision."""
    revision: int
    """Latest revision."""


class EventData(Answer):
    """Data that every event has."""

    at: datetime
    """Time at which it happened (UTC)."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""


class Execution(Answer):
    """An execution of a motion; poll it until its state is final."""

    attempts: int
    """Number of times that a worker has begun with it, this one included; more than 1 where a
    worker or the server ended under it."""
    cancel_requested_at: datetime | None
    """Time of the first request to end it (UTC), whatever came of it; null if there was none,
    or if the version did not record it."""
    created_at: datetime
    """Time of the request (UTC)."""
    failure: Failure | None
    """Reason why it was aborted or canceled."""
    finished_at: datetime | None
    """Time at which it ended (UTC)."""
    group: str
    """Group that moves; of several plans the one that spans theirs."""
    id: str
    """Id of the execution."""
    request: ExecutionTerms
    """The request, defaults filled in, without a motion of one's own."""
    scene: str
    """Id of the scene it moves in."""
    started_at: datetime | None
    """Time at which it began to move (UTC)."""
    state: ExecutionState
    """succeeded, canceled and aborted are final."""
    status: ExecutionStatus | None
    """The latest status; null before it began."""
    unrecorded: list[str]
    """Facts that the database does not hold yet, because it is full, locked or away: `cancel`,
    `controls`, `events`, `end`. They are written as soon as possible; requests are carried out
    all the same."""
    delays: list[float] | None = None
    """Time at which each of `plans` begins [s]; null for one motion."""
    is_waiting: bool = False
    """Whether it waits for its robots, and is proven once it begins."""
    motions: list[FollowedMotion] = Field(default=[], validate_default=True)
    """Motions that it went on with instead of the requested one, in order."""
    replanned: Replanned | None = None
    """Plan that is carried out instead, as `on_not_certified` says; null if the requested
    motion held."""
    sampling: SamplingReserve | None = None
    """Effect of a controller that samples the motion, once it has ended; null for others."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds of the stages `load` and `execute`, once it has ended; of a failure those of
    `failure` [s]."""


class OtherExecutionEvent(Answer):
    """One that a newer server has."""

    event: str
    data: Any
    id: str


type ExecutionEvent = Annotated[
    Annotated[
        QueuedEvent
        | StartedEvent
        | StageEvent
        | ControlsEvent
        | StatusEvent
        | MotionEvent
        | FinishedEvent,
        Field(discriminator="event"),
    ]
    | OtherExecutionEvent,
    Field(union_mode="left_to_right"),
]
"""Event of an execution."""


class ExecutionPage(Answer):
    """Executions, newest first."""

    items: list[Execution]
    """Executions on this page."""
    next: str | None
    """Cursor of the next page; null on the last one."""


class ExecutionSource(Answer):
    """An execution has measured the robot there."""

    id: str
    """Id of the execution."""
    type: Literal["execution"]
    """Kind of source."""


type ExecutionState = (
    Literal[
        "accepted",
        "executing",
        "paused",
        "canceling",
        "aborting",
        "succeeded",
        "canceled",
        "aborted",
    ]
    | str
)
"""States of an execution: those of ROS 2 actions, paused, aborting; the last three are final.
One that is aborting has failed, and its robot comes to rest."""


class ExecutionStatus(Answer):
    """Progress of an execution; also the data of its events."""

    contacts: list[Contact]
    """Touches so far that the scene does not allow."""
    max_tracking_error: float
    """Largest tracking error so far [rad or m]."""
    positions: list[float]
    """Measured positions [rad or m]."""
    progress: float
    """Share of the path's length that is done, 0 to 1, by place, not by the clock: it shrinks
    on the way back."""
    state: ExecutionState
    """State of the execution."""
    time: float
    """Time along the motion [s]."""
    tracking_error: float
    """Largest distance of a joint from where it should be, now [rad or m]."""
    ahead: float | None = None
    """Time along the motion that it does not pass [s]: it rests before it until an edit of the
    scene clears the way; null for none."""
    behind: float | None = None
    """Time along the motion that it does not pass on the way back [s]; null for none."""
    held: list[HeldStatus] = Field(default=[], validate_default=True)
    """Objects that are held by contact and moved along, where the driver measures them."""
    jitter: Jitter | None = None
    """Delays of the controller's ticks so far; null if not recorded."""
    lateness: float | None = None
    """Longest delay so far with which the controller looked at the clock [s]; load on the
    machine makes the motion fall behind; null if not recorded."""
    motion: int = 0
    """Number of the motion that `time` and `progress` are about: 0 is the one that was asked
    for, the others are in `motions`."""
    path_velocity: float | None = None
    """Seconds of the motion per second of the robot's clock, now; negative is backwards; null
    if not recorded."""
    torques: list[float] | None = None
    """Measured torques or forces of the motors [N m or N]; null if not known."""
    velocities: list[float] | None = None
    """Measured velocities [rad/s or m/s]; null if not recorded."""


class ExecutionTerms(Answer):
    """Terms on which a motion is carried out, and the plan or plans that it is from."""

    delays: list[float] | None = None
    """Time at which each of `plans` begins [s]; null for the smallest delays that are proven,
    as `POST /trajectories/schedule` finds them."""
    driver: DriverName | UrRtdeDriver = "simulated"
    """Driver of the motion."""
    gripper: GripperRequest | None = None
    """Open or close a gripper, from where its fingers are, and take hold of an object or let it
    go."""
    on_conflict: Literal["stop", "slow", "replan", "ignore"] | str = "stop"
    """Action while it moves if an edit of the scene is in its way: `stop` comes to rest on the
    path and ends (`path_blocked`); `slow` rests before the conflict and goes on once a later
    edit has cleared the way; `replan` does so too, and goes on with a new plan to the same
    configuration, without a rest where that is proven; `ignore` only tells. With `replan`, no
    other robot of the scene may move until it ends."""
    on_not_certified: Literal["refuse", "replan"] | str = "refuse"
    """Action if the plan's motion does not begin where the robot is, or is not proven in the
    latest revision: `refuse` answers 409; `replan` waits for a new plan from where the robot is
    to the same configuration (`replanned`), and answers 409 if there is none. With `when_busy:
    wait` that is done once its robots are free; without a plan it ends with the refusal."""
    plan: str | None = None
    """Id of a plan that succeeded; null for several, and for a motion of one's own."""
    plans: list[str] | None = None
    """Ids of plans of one scene, which are carried out as one motion with one clock, the most
    urgent first; no joint is in two of them."""
    speed: float = 1.0
    """Seconds of the motion per second; above 1 the simulation's clock runs faster than real
    time, and the motion stays as it is."""
    title: str | None = None
    """Title of the motion in replays of the scene."""
    when_busy: Literal["refuse", "wait"] | str = "refuse"
    """Action if another execution moves one of its robots, or waits for one: `refuse` answers
    409; `wait` begins once they are free, in the order of requests, and is proven then, from
    where they are."""


class ExecutionVerdict(Answer):
    """Effect of an edit of the scene on an execution that waits or moves."""

    id: str
    """Id of the execution."""
    verdict: Literal["unaffected", "conflict"] | str
    """Whether what is left of its motion is proven in this revision."""
    action: Literal["stop", "slow", "replan", "ignore"] | str | None = None
    """Action that is taken, as the execution's `on_conflict` says."""
    check: str | None = None
    """Check of the certificate that fails, mostly `clearance`; `undecided` if there was no
    verdict in time, `request` if the motion's terms name what is gone, `beside` if it may meet
    another execution."""
    fraction: float | None = None
    """Share of the path's length that is done there, 0 to 1."""
    other: str | None = None
    """Id of the execution that it may meet, if that is the check."""
    pair: tuple[str, str] | None = None
    """Full names of the bodies that come too near, if it is about two."""
    seconds: float | None = None
    """Time to that place from where the robot was, at the pace of the motion [s]."""
    time: float | None = None
    """Time along the motion of the conflict [s]."""


class FailedCheck(Answer):
    """A check of the certificate that failed."""

    bound: float | None
    """Bound of the check, in `unit`; null where it is not finite."""
    name: str
    """Name of the check."""
    value: float | None
    """Worst value of the check, in `unit`; null where it is not finite."""
    where: str
    """The joint, frame or bodies, or empty."""
    positions: list[float] | None = None
    """The group's positions at that time [rad or m]."""
    time: float | None = None
    """Time on the motion at which the value is worst [s]."""
    unit: CheckUnit | None = None
    """Unit of value and bound; `1` for a number without one."""


type Failure = Annotated[
    Annotated[
        SceneInvalidFailure
        | SceneEditImpossibleFailure
        | AssetNotFoundFailure
        | ModelInvalidFailure
        | ProblemInvalidFailure
        | UnknownNameFailure
        | StartInCollisionFailure
        | StartTooNearFailure
        | StartOutOfLimitsFailure
        | StartViolatesConstraintFailure
        | GoalOutOfLimitsFailure
        | GoalInCollisionFailure
        | GoalTooNearFailure
        | GoalUnreachableFailure
        | GoalViolatesConstraintFailure
        | ApproachBlockedFailure
        | LineBlockedFailure
        | NoPathFoundFailure
        | DeadlineExceededFailure
        | CanceledFailure
        | RetimingFailedFailure
        | ScheduleNotFoundFailure
        | GraspMissedFailure
        | NotCertifiedFailure
        | IllegalTransitionFailure
        | TrackingLostFailure
        | ContactFailure
        | TorqueLimitReachedFailure
        | GraspLostFailure
        | PathBlockedFailure
        | DriverLostFailure
        | WorkerCrashedFailure
        | WorkerUnresponsiveFailure
        | HostLostFailure
        | MemoryLimitExceededFailure
        | ServerRestartedFailure
        | InternalErrorFailure
        | NotFoundFailure
        | StartMismatchFailure
        | RobotStateUnknownFailure,
        Field(discriminator="code"),
    ]
    | OtherFailure,
    Field(union_mode="left_to_right"),
]
"""Reason why a job has no result: its `code` says what its `evidence` has. Codes and evidence
of older versions are passed on as they are."""


class FaultsEvidence(Answer):
    """Faults of a body or of its parameters."""

    faults: list[DocumentFault]
    """Faults, at most 20 of them."""


class Files(Answer):
    """The files of a robot or a mesh, as they were when it entered the scene."""

    card: str
    """The `robot.yaml` that goes with it; empty for none."""
    main: str
    """The robot's description, or the mesh; one of the paths."""
    named: str
    """Name in the document: `model`, or the mesh's `uri`."""
    sha256: dict[str, str]
    """sha256 of the bytes of every file, by path relative to the folder of all."""


class FinishedData(Answer):
    """End of a job."""

    at: datetime
    """Time at which it happened (UTC)."""
    state: Literal["succeeded", "failed", "canceled"] | str
    """Final state of the job."""
    failure: Failure | None = None
    """Reason why there is no result."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""


class FinishedEvent(Answer):
    """The job ended; no event follows."""

    data: Json[FinishedData]
    """End of the job."""
    event: Literal["finished"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class FkResponse(Answer):
    """Poses per configuration, in order."""

    results: list[dict[str, Pose]]
    """Pose in world per frame, in the order of the configurations."""


class FollowedMotion(Answer):
    """A motion that an execution went on with, since an edit was in the way of the one before."""

    duration: float
    """Duration of the whole motion [s]."""
    is_spliced: bool
    """Whether the robot left the motion before it without a rest; if not, it began at rest,
    where the robot had stopped."""
    left_at: float
    """Place on the motion before it where that was left [s]."""
    number: int
    """Number of the motion; 1 is the first one after the requested motion."""
    plan: str
    """Id of the plan that it follows."""
    revision: int
    """Revision of the scene in which it is proven."""


class FoundDeviation(Answer):
    """Largest deviation of a tool from its line that was found, between waypoints too."""

    position: float
    """Distance of the tool's origin from the line [m]."""
    rotation: float
    """Angle between the tool's rotation and that of the line [rad]."""


class FrameDocument(Answer):
    """A named pose: a target, a tool point."""

    name: str
    """Name of the frame."""
    parent: str = "world"
    """Parent of the frame: an object, a frame, `robot::link` or `world`."""
    pose: PoseDocument | None = None
    """X_PF, pose of the frame in its parent."""


class FunnelEvidence(Answer):
    """Number of samples of inverse kinematics that pass each test."""

    collision_free: int
    """Number of those that are free of collisions."""
    converged: int
    """Number of them that reached the target."""
    distinct: int
    """Number of those that differ from all others."""
    rejected_by: list[RejectedPair]
    """Collisions by pair, the most frequent first."""
    tried: int
    """Number of seeds given to the solver."""
    within_limits: int
    """Number of the converged ones within the joint limits."""
    approach_ok: int | None = None
    """Number of the free ones that keep path constraints and have free approach and retreat."""
    blocked_by: list[BlockedMoves] | None = None
    """Reasons that stopped approaches and retreats, the most frequent first."""
    breaking: int | None = None
    """Number of the free ones that violate a path constraint."""
    rejected: list[RejectedSamples] | None = None
    """Reasons why the others are not among the distinct ones; the counts add up to those tried."""
    summary: str | None = None
    """Summary of the funnel as a sentence."""
    violating: int | None = None
    """Goal configurations dropped for path constraints, whole turns included."""


class Geometry(Answer):
    """Shapes of the bodies of a scene, as they look; those of a revision never change."""

    bodies: list[VisibleBody]
    """Bodies, sorted by name."""


class OtherGoal(Answer):
    """One that a newer server has."""

    type: str


type Goal = Annotated[
    Annotated[
        JointGoal | ConfigurationGoal | PoseGoal | RegionGoal | RelativeGoal | LineGoal | PathGoal,
        Field(discriminator="type"),
    ]
    | OtherGoal,
    Field(union_mode="left_to_right"),
]
"""Goal of a motion."""


class GoalConstraintEvidence(Answer):
    """Path constraints that all goal configurations violate."""

    violations: list[CountedViolation]
    """Violations by constraint, the most frequent first."""
    nearest: NearestPoseEvidence | NearestConfigurationEvidence | None = None
    """The nearest feasible pose or configuration, null if none was found."""
    relaxation: ConfigurationRelaxation | ToolRelaxation | None = None
    """Constraint that would have to give way, and how far."""


class GoalEvidence(Answer):
    """Why no goal configuration is feasible, and what would have to change."""

    funnel: FunnelEvidence
    """Number of samples that passed each test."""
    nearest: NearestPoseEvidence | NearestConfigurationEvidence | None = None
    """The nearest feasible pose or configuration, null if none was found."""
    pairs: list[ViolatingPair] | None = None
    """Pairs of the least infeasible of the given configurations."""
    relaxation: ConfigurationRelaxation | ToolRelaxation | None = None
    """Changes that would be sufficient."""


class GoalInCollisionFailure(Answer):
    """In all goal configurations bodies overlap."""

    code: Literal["goal_in_collision"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class GoalInCollisionProblem(Answer):
    """In all goal configurations bodies overlap."""

    code: Literal["goal_in_collision"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class GoalLimitsEvidence(Answer):
    """Positions of the goal's configurations outside their limits."""

    joints: list[ViolatedLimit]
    """Coordinates that are outside."""
    nearest: NearestPoseEvidence | NearestConfigurationEvidence | None = None
    """The nearest feasible configuration, null if none was found."""
    relaxation: ConfigurationRelaxation | ToolRelaxation | None = None
    """Changes that would be sufficient."""


class GoalOutOfLimitsFailure(Answer):
    """Every goal configuration violates position limits."""

    code: Literal["goal_out_of_limits"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GoalLimitsEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class GoalOutOfLimitsProblem(Answer):
    """Every goal configuration violates position limits."""

    code: Literal["goal_out_of_limits"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: GoalLimitsEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class GoalTooNearFailure(Answer):
    """Some goal configurations are free, none keeps its margins."""

    code: Literal["goal_too_near"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class GoalTooNearProblem(Answer):
    """Some goal configurations are free, none keeps its margins."""

    code: Literal["goal_too_near"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class GoalUnreachableFailure(Answer):
    """No configuration reaches the goal."""

    code: Literal["goal_unreachable"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class GoalUnreachableProblem(Answer):
    """No configuration reaches the goal."""

    code: Literal["goal_unreachable"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: GoalEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class GoalViolatesConstraintFailure(Answer):
    """Every goal configuration violates path constraints."""

    code: Literal["goal_violates_constraint"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GoalConstraintEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class GoalViolatesConstraintProblem(Answer):
    """Every goal configuration violates path constraints."""

    code: Literal["goal_violates_constraint"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: GoalConstraintEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class GoalsReport(Answer):
    """Report of the goals stage."""

    funnel: IkFunnel
    """Number of samples that passed each test."""
    num_configurations: int
    """Number of goal configurations that were offered to search."""


class Grasp(Answer):
    """Close on an object, and hold it from then on."""

    object: str
    """Name of the object; it must be `movable`, and between the fingers."""
    by: Literal["weld", "contact"] | str = "weld"
    """`weld`: it follows the frame as if welded to it; `contact`: a simulated robot holds it by
    friction alone, between fingers that press with `force`, and may lose it (`grasp_lost`).
    Plans and proofs take it to be welded where it is held. `contact` needs the `simulated`
    driver, and an object with a `mass`."""
    frame: str | None = None
    """Frame that the object follows from then on; null for the first tool frame of the gripper."""
    friction: float = 0.5
    """Of `contact`: coefficient of Coulomb friction a of the object; that of a contact is 2ab /
    (a + b), where the b of the finger is 1 unless its description says otherwise."""
    gap: float = 0.0002
    """Distance that the nearest finger keeps from the object [m]. The grasp is a weld, not a
    contact, and a simulated robot that touches something is stopped."""
    reach: float = 0.002
    """Largest distance of any finger from the object [m]; beyond it the object is not held
    (`grasp_missed`)."""
    slip: float = 0.005
    """Of `contact`: largest distance by which the object may move in the gripper before it
    counts as lost [m]. Proofs know nothing of it: bodies may come that much nearer to it."""
    touch: list[str] | None = None
    """Bodies that the object may touch then; null for those of `attach`: the fingers, and
    bodies that move rigidly with the frame."""


class GraspEvidence(Answer):
    """Why fingers do not hold an object."""

    bound: float
    """Largest distances that are allowed [m]."""
    distances: list[float | None]
    """Distance between the object and each finger then [m]; null beyond 5 cm."""
    object: str
    """Name of the object."""
    width: float
    """Distance of the fingers where they have closed [m]."""


class GraspLostEvidence(Answer):
    """Object that slipped in its gripper, and how far."""

    bound: float
    """Largest slip that is tolerated [m]."""
    frame: str
    """Frame that it is attached to."""
    object: str
    """Name of the object."""
    slip: float
    """Largest distance of a corner of its bounding box from where it was held [m]."""
    time: float
    """Time along the motion [s]."""


class GraspLostFailure(Answer):
    """An object slipped out of its gripper."""

    code: Literal["grasp_lost"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GraspLostEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class GraspMissedFailure(Answer):
    """Fingers that close do not hold the object."""

    code: Literal["grasp_missed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: GraspEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class GraspMissedProblem(Answer):
    """Fingers that close do not hold the object."""

    code: Literal["grasp_missed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: GraspEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class GripDocument(Answer):
    """Contact by which a gripper holds an object: friction, and nothing else."""

    force: float
    """Force that presses each finger on the object [N]."""
    gripper: str
    """Group that is a gripper, `robot::group`."""
    friction: float = 0.5
    """Coefficient of Coulomb friction a of the object; that of a contact is 2ab / (a + b),
    where the b of the finger is 1 unless its description says otherwise."""
    slip: float = 0.005
    """Largest distance by which the object may move in the gripper before it counts as lost [m]."""


class Gripper(Answer):
    """Width of a group that is a parallel gripper: `travel` times (position - `lower`)."""

    joint: str
    """Full name of the joint that moves its fingers."""
    lower: float
    """Position of that joint where the fingers meet [m]."""
    max_width: float
    """Largest distance of the fingers [m]."""
    travel: float
    """Distance that the fingers part with each metre of the joint [m/m]."""


class GripperRequest(Answer):
    """Open or close a gripper, from where its fingers are."""

    group: str | list[str]
    """A group that is a gripper: `robot` for its default group, `robot::group`, or a group that
    the scene names; a list of several, or their names joined by `+`, for one group of all their
    joints, in this order."""
    scene: str
    """Id of a scene; it moves in its latest revision."""
    force: float | None = None
    """Largest force of the motor of the fingers' joint [N], where a driver has forces: one that
    needs more is stopped (`torque_limit_reached`); null for the joint's own limit. With a grasp
    by `contact`, the force that presses each finger on the object."""
    grasp: Grasp | None = None
    """Close on an object; once the fingers rest it is attached as `attach` does it, where it
    was measured to be."""
    release: str | None = None
    """Name of the object to let go of: it is detached once the fingers have opened to `width`."""
    width: float | None = None
    """Distance that the fingers shall have [m], from 0 to `gripper.max_width` of the group;
    null to close on the object of `grasp`."""


class GripperState(Answer):
    """Width of a gripper, and the objects that it holds."""

    group: str
    """Full name of the gripper."""
    holds: list[str]
    """Objects that are attached to a frame of the gripper."""
    max_width: float
    """Largest distance that the fingers can have [m]."""
    robot: str
    """Robot that the gripper belongs to."""
    width: float
    """Distance of the fingers [m], as `positions` has them."""


class Group(Answer):
    """Joints that are planned for together."""

    aliases: list[str]
    """Other names that it answers to."""
    configurations: dict[str, list[float]]
    """Named configurations, in the group's order [rad or m]."""
    joints: list[Joint]
    """Joints in the group's order."""
    limits: Limits
    """Limits of its joints."""
    name: str
    """`robot`, `robot::group`, or its own in the scene."""
    position_names: list[str]
    """A name per position coordinate, in order."""
    positions: list[float]
    """The current state [rad or m]."""
    tool_frames: list[str]
    """Frames that it moves; the first is the default."""
    velocity_names: list[str]
    """A name per velocity coordinate, in order."""
    gripper: Gripper | None = None
    """Width of a group that is a gripper; left out of other groups."""
    members: list[str] = Field(default=[], validate_default=True)
    """Groups of robots that it spans, in order; left out of one of these."""


class Health(Answer):
    """Sign that the server is there."""

    kernel: str
    """Instruction set of the native collision kernel; `none` where it was not built, and Drake
    answers everything, more slowly."""
    status: Literal["ok"]
    """Always `ok`; a server that is not there does not answer."""
    version: str
    """Version of Wayproof."""


class HeldObject(Answer):
    """An object that a robot holds."""

    frame: str
    """Frame of a robot that it is attached to."""
    object: str
    """Name of the object."""
    by: Literal["weld", "contact"] | str = "weld"
    """How it is held: welded, or by the friction of fingers."""
    is_lost: bool = False
    """Whether it has left its place in the gripper that moves."""
    pose: MeasuredPose | None = None
    """Pose in that frame: as measured while its robot moves, else as the latest revision has it."""
    slip: float | None = None
    """Largest distance of a corner of its bounding box from where it was proven to be held, as
    measured while its robot moves [m]; null where nothing is measured."""


class HeldStatus(Answer):
    """An object that a gripper holds by contact, as measured."""

    bound: float
    """Largest `slip` that does not count as a loss [m]."""
    frame: str
    """Frame of the robot that it is attached to."""
    is_lost: bool
    """Whether it has left its place in the gripper."""
    object: str
    """Name of the object."""
    pose: MeasuredPose
    """Pose of the object in that frame."""
    slip: float
    """Largest distance of a corner of its bounding box from where it was proven to be held [m]."""
    world_pose: MeasuredPose
    """Pose of the object in the world."""


class HostEvidence(Answer):
    """Whom a request was for."""

    host: str
    """Host in the request."""


class HostLostEvidence(Answer):
    """Machine that was lost."""

    host: str
    """Address of the machine and the first digits of its id."""
    attempts: int | None = None
    """Number of times that the job was started."""
    during: str | None = None
    """The stage that it told last."""


class HostLostFailure(Answer):
    """The machine that the job ran on was lost, and it may not run again, or it was lost too
    often."""

    code: Literal["host_lost"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: HostLostEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class HostLostProblem(Answer):
    """The machine that the job ran on was lost, and it may not run again, or it was lost too
    often."""

    code: Literal["host_lost"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: HostLostEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class HostNotAllowedProblem(Answer):
    """The request is for a server of another name."""

    code: Literal["host_not_allowed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: HostEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class HttpErrorProblem(Answer):
    """Any other status."""

    code: Literal["http_error"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: NoEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class IdempotencyConflictProblem(Answer):
    """An idempotency key came again with another request."""

    code: Literal["idempotency_conflict"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: IdempotencyEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class IdempotencyEvidence(Answer):
    """Resource that the first request with the key made."""

    key: str
    """The key."""
    batch: str | None = None
    """Id of the batch."""
    job: str | None = None
    """Id of the plan, the regions or the execution."""
    scene: str | None = None
    """Id of the scene."""
    webhook: str | None = None
    """Id of the webhook."""


class Ik(Answer):
    """Options of the search for goal configurations."""

    allowed_time: float | None = None
    """Time for finding them, or for saying why there is none [s]; null for as long as there is."""
    joint_weights: dict[str, float] = Field(default={}, validate_default=True)
    """Factor on each joint's part of the distance from the start, by full name
    (`robot::joint`); 1 for joints that are not named [1]."""
    max_configurations: int = 100
    """Number of configurations at most, the nearest to the start of all that are found; as many
    are looked for, but 100 at least, and until 40 in a row are known already."""
    max_trials: int = 300
    """Largest number of seeds of the solver, over all poses."""
    pose_metric: PoseMetric | None = None
    """Metric of the nearest pose to one that no configuration reaches."""


class IkFunnel(Answer):
    """Number of samples that pass each test, with the reason of every rejected sample."""

    collision_free: int
    """Number of those that touch nothing."""
    converged: int
    """Number of those that reached the target within tolerance."""
    distinct: int
    """Number of those that differ from all others."""
    rejected_by: list[CollidingPair]
    """Pairs that the colliding ones hit, of the first few that were measured."""
    tried: int
    """Number of seeds given to the solver."""
    within_limits: int
    """Number of those that kept the joint limits."""
    approach_ok: int = 0
    """Number of those with a free, continuous approach and retreat; all without a request for
    them."""
    blocked_by: list[ApproachFailures] = Field(default=[], validate_default=True)
    """Reasons that stopped approaches and retreats, most frequent first."""
    breaking: int = 0
    """Number of collision-free samples that violate a path constraint."""
    rejected: list[Rejection] = Field(default=[], validate_default=True)
    """Reasons why the others are no solutions."""
    summary: str = ""
    """The same as a sentence."""
    violating: int = 0
    """Number of goal configurations, whole turns included, that were dropped because they or
    their lines violate a path constraint."""


class IkResponse(Answer):
    """All distinct goal configurations, nearest to the start first, or why there are none."""

    configurations: list[IkSolution]
    """Distinct goal configurations that are free and within limits."""
    failure: Failure | None
    """Reason why there is none, null if there is one: `goal_unreachable`, `goal_in_collision`,
    `goal_too_near`, `approach_blocked`, `goal_violates_constraint` or `deadline_exceeded`. The
    evidence has the `nearest` feasible pose, the `relaxation` that is sufficient, what blocks
    the approaches and what is violated; at a deadline, the funnel so far."""
    funnel: IkFunnel | None
    """Number of samples that passed each test."""


class IkSolution(Answer):
    """A goal configuration, and how good it is."""

    branch: Branch | None
    """Branch of a six-joint arm with a spherical wrist or one like Universal Robots'; null for
    others."""
    clearance: float | None
    """Smallest signed distance of any two bodies [m]; null if nothing can collide."""
    distance: float
    """Distance from the start, by `ik.joint_weights` [rad or m]; the answers are sorted by it."""
    limit_margin: float | None
    """Smallest distance to a position limit as a share of its range, 0 to 0.5; null if nothing
    is limited."""
    manipulability: float
    """Yoshikawa's sqrt(det(J J^T)) of the tool; it mixes metres and radians, so it compares
    configurations of one arm."""
    pair: tuple[str, str] | None
    """Full names of the two bodies of `clearance`."""
    pose_index: int
    """Index of the goal's pose that it reaches, from 0."""
    positions: list[float]
    """The group's positions [rad or m]."""


class IllegalTransitionFailure(Answer):
    """The present state does not allow an event."""

    code: Literal["illegal_transition"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: TransitionEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class IllegalTransitionProblem(Answer):
    """The present state does not allow an event."""

    code: Literal["illegal_transition"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: TransitionEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class InUseEvidence(Answer):
    """Resource that is not deleted, and what uses it."""

    id: str
    """Id of the resource."""
    used_by: str
    """Id of what uses it and has not ended."""


class InternalErrorEvidence(Answer):
    """A fault of ours; the log has the rest."""

    during: str | None = None
    """The stage that it told last."""
    exception: str | None = None
    """Class of the exception."""
    reference: str | None = None
    """Reference under which the server's log says more."""


class InternalErrorFailure(Answer):
    """The task raised what it should not."""

    code: Literal["internal_error"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: InternalErrorEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class InternalErrorProblem(Answer):
    """The task raised what it should not."""

    code: Literal["internal_error"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: InternalErrorEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Interpolation(Answer):
    """Verdict whether the samples, read in one way, keep what the motion was proven to keep."""

    deviation: float | None
    """Largest distance of any coordinate from the exact motion [rad or m]; null if that is not
    known."""
    failed: list[Check]
    """Checks that did not pass."""
    kind: Literal["linear", "cubic", "quintic"] | str
    """Interpolation between samples: straight lines (`linear`: positions alone), polynomials of
    degree 3 (`cubic`: positions and velocities) or of degree 5 (`quintic`: accelerations too)."""
    proven: bool
    """Whether every check passed on the whole interval, those in `unchecked` excepted."""
    reason: str
    """Reason why it is not proven where no check says so, or empty."""
    unchecked: list[str]
    """Checks of the certificate that straight lines are not held to: at every sample their
    velocity jumps."""
    up_to_period: float | None
    """Longest `sample_period` with which it is known to be proven [s]; the duration if any
    period is, null if none is known. For samples that are evenly apart, only their own period
    is considered."""


class Jitter(Answer):
    """Delays of the ticks of the controller."""

    max: float
    """Largest delay [s]."""
    median: float
    """Median delay, at most 5 % too large [s]."""
    p99: float
    """99th percentile, at most 5 % too large [s]."""
    ticks: int
    """Number of ticks."""


class OtherJobEvent(Answer):
    """One that a newer server has."""

    event: str
    data: Any
    id: str


type JobEvent = Annotated[
    Annotated[
        QueuedEvent
        | StartedEvent
        | RequeuedEvent
        | StageEvent
        | ProgressEvent
        | BestSoFarEvent
        | FinishedEvent,
        Field(discriminator="event"),
    ]
    | OtherJobEvent,
    Field(union_mode="left_to_right"),
]
"""Event of a plan or of regions."""


class JobIdEvidence(Answer):
    """Job that does not exist."""

    id: str
    """Id that was given."""


type JobState = Literal["queued", "running", "succeeded", "failed", "canceled"] | str
"""State of a job; the last three are final and written once."""


class Joint(Answer):
    """A joint of a group."""

    name: str
    """Full name, `robot::joint`."""
    type: JointType
    """Type of the joint. Whole turns are nothing only to continuous joints; a joint that
    another one follows by less is revolute."""
    steering: Steering | None = None
    """Steering of a planar joint; null if it moves any way."""


class JointGoal(Answer):
    """Reach a configuration, or any of several."""

    positions: list[float] | list[list[float]]
    """The group's positions, one list or several [rad or m]."""
    type: Literal["joint"]
    """Kind of goal."""


class JointLimits(Answer):
    """Some coordinates of the group stay within bounds, besides those of the robot."""

    limits: dict[str, list[float]]
    """Smallest and largest position by the name of a joint, or of a coordinate of one that has
    several [rad or m]."""
    type: Literal["joint_limits"]
    """Kind of constraint."""


type JointPositions = dict[str, float | list[float]]
"""Positions by joint of the robot: a number, or one for each of its coordinates."""

type JointType = Literal["revolute", "continuous", "prismatic", "planar", "floating"] | str
"""Types of joints; positions and velocities are in Drake's order."""


class KeepIn(Answer):
    """The origin of a frame stays in a box."""

    box: Box
    """Box in which the origin must be."""
    frame: str
    """Frame whose origin is meant."""
    type: Literal["keep_in"]
    """Kind of constraint."""


class KeepOut(Answer):
    """The origin of a frame stays out of a box."""

    box: Box
    """Box in which the origin must not be."""
    frame: str
    """Frame whose origin is meant."""
    type: Literal["keep_out"]
    """Kind of constraint."""


class LargerTolerance(Answer):
    """Tolerances with which the nearest pose solves the goal."""

    pose_index: int
    """Index of the goal's pose, from 0."""
    position: list[float]
    """Tolerance along x, y, z of the goal [m]."""
    rotation: list[float]
    """Tolerance about x, y, z of the goal [rad]."""


type Limit = (
    Literal[
        "velocity",
        "acceleration",
        "jerk",
        "torque",
        "tool_speed",
        "tool_acceleration",
        "speed_zone",
        "acceleration_bounds",
    ]
    | str
)
"""Limits on a motion."""


class LimitViolation(Answer):
    """A joint outside its position limits."""

    joint: str
    """Name of the position coordinate."""
    lower: float | None
    """Smallest allowed [rad or m]; null for none."""
    upper: float | None
    """Largest allowed [rad or m]; null for none."""
    value: float
    """Position of the coordinate [rad or m]."""


class Limits(Answer):
    """Limits of the joints of a group; null is unlimited. Positions are limited per coordinate,
    rates per block by the Euclidean norm of its velocity coordinates; a scalar joint is a block
    of its own. Joints that follow those of the group keep their own limits within these."""

    acceleration: list[float | None]
    """Largest acceleration per block [rad/s^2 or m/s^2]."""
    blocks: list[str]
    """Names of the blocks, in the order of the rates."""
    effort: list[float | None]
    """Largest torque or force per block [N m or N]."""
    jerk: list[float | None]
    """Largest jerk per block [rad/s^3 or m/s^3]."""
    lower: list[float | None]
    """Smallest positions [rad or m]."""
    upper: list[float | None]
    """Largest positions [rad or m]."""
    velocity: list[float | None]
    """Largest velocity per block [rad/s or m/s]."""


class LineBlockedFailure(Answer):
    """A straight line stops before its end."""

    code: Literal["line_blocked"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: LineEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class LineBlockedProblem(Answer):
    """A straight line stops before its end."""

    code: Literal["line_blocked"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: LineEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class LineEvidence(Answer):
    """Place at which a straight line stops."""

    fraction: float
    """Share of the line that is free [0 to 1]."""
    length: float
    """Length of the line [m]."""
    line: int
    """Index of the goal's line, from 0."""
    stopped_by: LineStopEvidence
    """Place and reason of the stop."""


class LineGoal(Answer):
    """Bring a tool frame to a pose, or by a displacement, in a straight line from the start."""

    type: Literal["line"]
    """Kind of goal."""
    deviation: Deviation | None = None
    """Largest deviation of the motion from the line, between samples too."""
    displacement: Translation | None = None
    """Displacement from where the tool stands; this or `pose`."""
    frame: str | None = None
    """The tool frame: any that the group moves; null for its default."""
    pose: Pose | None = None
    """Pose at which the line ends, and the rotation turns along with the translation; this or
    `displacement`."""


type LineLeg = Literal["approach", "retreat"] | str
"""Straight line to a goal, or away from it."""


class LineResponse(Answer):
    """Waypoints along the free part of the line, its length, and what stops it."""

    deviation: FoundDeviation
    """Largest deviation of the tool from the line, between waypoints too."""
    fraction: float
    """Share of the line that is reached, 0 to 1 [1]."""
    fractions: list[float]
    """Share of the line at every waypoint [1]."""
    length: float
    """Distance that the tool's origin gets along the line [m]."""
    poses: list[Pose] | None
    """Pose of the tool at each waypoint, in world; null if not asked for."""
    positions: list[list[float]]
    """Waypoints from the start on, to be joined straight [rad or m]."""
    stopped_by: LineStop | None
    """Reason why the line stops; null if all is reached."""


class LineStop(Answer):
    """Place and reason of a line's stop before its end."""

    fraction: float
    """Share of the line that was reached, to about 1e-5 [1]."""
    joint: str | None
    """The position coordinate at its limit, for `limit`."""
    pair: Pair | None
    """The two bodies just beyond, for `collision`."""
    positions: list[float]
    """Positions of the group there [rad or m]."""
    reason: LineStopReason
    """Reason of the stop: a joint would leave its range (`limit`), two bodies would be nearer
    than their margin (`collision`), the joints would have to move without bound
    (`singularity`), or they cannot move the tool that way (`unreachable`)."""
    singular_value: float
    """Smallest singular value there of the tool's Jacobian, of those that are not zero
    everywhere [1 or m per rad or m]."""
    where: Pose
    """Pose of the tool there, in world."""


class LineStopEvidence(Answer):
    """Place and reason of a straight line's stop."""

    fraction: float
    """Share of the line that is free [0 to 1]."""
    joint: str | None
    """Joint that would leave its limits, if that is the reason."""
    pair: ViolatingPair | None
    """Pair that would violate its margin, if that is the reason."""
    positions: list[float]
    """The group's positions there [rad or m]."""
    reason: LineStopReason
    """Reason why the line stops."""
    singular_value: float | None
    """Least singular value of the Jacobian there."""
    where: PlainPose
    """Pose of the tool there, in world."""


type LineStopReason = Literal["limit", "singularity", "collision", "unreachable"] | str
"""Reason why a straight line stops."""


class LiveState(Answer):
    """Present positions of the robots of a scene, and the objects that they hold."""

    attached: list[HeldObject]
    """Objects that robots hold."""
    revision: int
    """Latest revision; executions do not change it."""
    robots: list[RobotState]
    """Robots that have joints."""
    scene: str
    """Id of the scene."""
    grippers: list[GripperState] = Field(default=[], validate_default=True)
    """Groups that are grippers, and how wide they are open."""


class LockedJoints(Answer):
    """Some joints of the group stay where the start has them."""

    joints: list[str]
    """Full names."""
    type: Literal["locked_joints"]
    """Kind of constraint."""


class MarginDocument(Answer):
    """A distance that two bodies keep, other than the scene's margin."""

    bodies: list[str]
    margin: float
    """Distance that they keep [m]."""


class MeasuredPose(Answer):
    """A measured rigid transform."""

    position: list[float]
    """x, y, z [m]."""
    quaternion: list[float]
    """[w, x, y, z], of length 1."""


class MediaTypeEvidence(Answer):
    """Content types that are read instead."""

    got: str | None = None
    """The content type that came."""
    known: list[str] | None = None
    """Content types that are read."""


class MemoryEvidence(Answer):
    """Memory that the worker used."""

    bound: int
    """Memory that the worker may use [bytes]."""
    used: int
    """Largest memory that was seen [bytes]."""
    attempts: int | None = None
    """Number of times that the job was started."""
    during: str | None = None
    """The stage that it told last."""


class MemoryLimitExceededFailure(Answer):
    """The job needs more memory than a worker may use."""

    code: Literal["memory_limit_exceeded"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: MemoryEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class MemoryLimitExceededProblem(Answer):
    """The job needs more memory than a worker may use."""

    code: Literal["memory_limit_exceeded"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: MemoryEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class MeshDocument(Answer):
    """A mesh file; its convex hull is what counts."""

    uri: str
    """Path of an .obj, .vtk or .gltf file."""
    scale: list[float] = Field(default=[1.0, 1.0, 1.0], validate_default=True)
    """Factor on the size, or one factor per axis [1]."""


class MeshName(Answer):
    """A mesh, in a file of its own."""

    sha256: str
    """sha256 of the bytes of `GET /v1/scenes/{scene}/geometry/{sha256}.glb`: glTF 2.0, binary;
    as an exception to glTF its z axis points up."""


class MethodNotAllowedProblem(Answer):
    """The resource is there, but does not do that."""

    code: Literal["method_not_allowed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: NoEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Model(Answer):
    """A robot that scenes may name."""

    assumed: list[str]
    """Joints whose rate limits are assumed, because no source states them."""
    bodies: list[str]
    """Its bodies, in a robot of this name."""
    default_group: str
    """The group that the bare robot name stands for."""
    description: str
    """Description of the robot."""
    groups: list[Group]
    """Groups that can be planned for, in a robot of this name."""
    name: str
    """Name, as `model` of a scene's robot has it."""
    sources: list[Source]
    """Sources of its numbers."""


class ModelEvidence(Answer):
    """Fault of a robot, or of one of its files."""

    reason: str
    """What is wrong."""
    body: str | None = None
    """Body with the fault."""
    element: str | None = None
    """Element of the file with the fault."""
    elements: Any | None = None
    """Elements of the file with the fault."""
    file: str | None = None
    """File with the fault."""
    joint: str | None = None
    """Joint with the fault."""
    joints: list[str] | None = None
    """Joints with the fault."""
    link: str | None = None
    """Link with the fault."""
    robot: str | None = None
    """Robot of the scene that has the fault."""


class ModelInvalidFailure(Answer):
    """A robot file is unsafe or does not load."""

    code: Literal["model_invalid"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: ModelEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class ModelInvalidProblem(Answer):
    """A robot file is unsafe or does not load."""

    code: Literal["model_invalid"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: ModelEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class ModelList(Answer):
    """Robots there are."""

    items: list[str]
    """Names, sorted; GET /v1/models/{name} says more."""


class MotionData(Answer):
    """A motion that is followed from now on."""

    at: datetime
    """Time at which it happened (UTC)."""
    motions: list[FollowedMotion]
    """All motions so far, this one last."""
    number: int
    """Number of the motion."""
    trajectory: Polynomial
    """The whole motion; a spliced one has what was passed of the motion before it."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""


class MotionEvent(Answer):
    """The execution goes on with another motion."""

    data: Json[MotionData]
    """The motion that is followed from now on."""
    event: Literal["motion"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


type MotionInterpolation = Literal["polynomial", "quintic", "cubic", "cubic_spline", "linear"] | str
"""Interpolation of a motion between its instants."""


class MotionSchedule(Answer):
    """Time at which each motion begins, and the proof of all together."""

    certificate: Certificate
    """The proof of all motions as one."""
    delays: list[float]
    """Time at which each motion begins, in the order of the plans [s]: the first is as small as
    it can be, then the second, and so on."""
    duration: float
    """Time from the beginning of the first motion to the end of the last [s]."""
    group: str
    """Group that spans all the plans' groups."""
    groups: list[str]
    """Group of each plan, in their order."""
    stage: CertifyReport
    """Report of the proof."""
    waits: list[Wait]
    """Each motion that waits, in the order of the plans."""
    polynomial: Polynomial | None = None
    """All motions as one, if the request wants it."""


type MotionlessState = (
    Literal["queued", "running", "succeeded", "failed", "canceled", "unmoved"] | str
)
"""States of what has no motion to give."""


class NameEvidence(Answer):
    """A name that does not exist."""

    kind: NameKind
    """Kind of the name, such as `frame`."""
    known: list[str]
    """Names that exist."""
    name: str
    """Name that was given."""
    nearest: list[str] | None = None
    """Known names that were perhaps meant, the nearest first."""
    operation: int | None = None
    """Index of the operation of an edit, from 0."""


type NameKind = (
    Literal[
        "body",
        "configuration",
        "controller",
        "derivative",
        "frame",
        "group",
        "joint",
        "joint or block",
        "link",
        "object",
        "parameter",
        "part",
        "planar joint",
        "planar or floating joint",
        "planner",
        "position",
        "query parameter",
        "robot",
        "scene robot",
        "space",
    ]
    | str
)
"""Kinds of names that may not exist."""


class NearestConfigurationEvidence(Answer):
    """The feasible configuration that is nearest to the goal's."""

    binding: Literal["collision", "path_constraint", "limits"] | str
    """Reason why it is not nearer."""
    constraints: list[str]
    """Path constraints that would be violated nearer to the goal."""
    cut_short: bool
    """Whether time ran out, so that a nearer one may exist."""
    differences: dict[str, float]
    """Difference from the goal's configuration, by coordinate [rad or m]."""
    distance: float
    """Distance from the goal's configuration, in the metric of joints [rad or m]."""
    goal_index: int
    """Index of the goal's configuration that it is nearest to, from 0."""
    joints: list[str]
    """Coordinates at their limits."""
    pairs: list[tuple[str, str]]
    """Pairs of bodies at their margins."""
    positions: list[float]
    """The group's positions [rad or m]."""


class NearestPoseEvidence(Answer):
    """The feasible pose of the tool that is nearest to the goal."""

    binding: (
        Literal["collision", "path_constraint", "approach", "retreat", "limits", "reach"]
        | str
        | None
    )
    """Reason why it is not nearer; null where time ran out before that was known."""
    constraints: list[str]
    """Path constraints that would be violated nearer to the goal."""
    cut_short: bool
    """Whether time ran out, so that a nearer pose may exist."""
    goal: PlainPose
    """The goal's pose, moved within its tolerance to be as near as possible."""
    joints: list[str]
    """Coordinates at their limits."""
    line: dict[str, Any] | None
    """Place and reason of a stop of its approach or retreat nearer to the goal."""
    pairs: list[tuple[str, str]]
    """Pairs of bodies at their margins."""
    pose_index: int
    """Index of the goal's pose that it is nearest to, from 0."""
    position: list[float]
    """Position x, y, z in world [m]."""
    positions: list[float]
    """The group's positions there [rad or m]."""
    quaternion: list[float]
    """Rotation w, x, y, z in world."""
    rotation_error: float
    """Angle from the goal, its tolerance aside [rad]."""
    translation_error: float
    """Distance from the goal, its tolerance aside [m]."""


class NewWebhook(Answer):
    """A webhook that was just registered."""

    created_at: datetime
    """Time of the registration (UTC)."""
    disabled_at: datetime | None
    """Time since which nothing is sent, because it failed for days or said 410 (UTC); null if
    it is enabled."""
    events: list[WebhookEvent]
    """Events that are told."""
    failing_since: datetime | None
    """Time since which it has taken nothing that was sent (UTC); null if it takes them."""
    id: str
    """Id of the webhook."""
    reason: str
    """Reason of the last failure since a success, or empty."""
    secret: str
    """Secret that signs messages, `whsec_` and base64: it is shown once."""
    url: str
    """Address to which messages are posted."""


class NoEvidence(Answer):
    """Nothing: the detail says all."""


class NoPathFoundFailure(Answer):
    """The planner ended without an exact solution."""

    code: Literal["no_path_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: SearchEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class NoPathFoundProblem(Answer):
    """The planner ended without an exact solution."""

    code: Literal["no_path_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: SearchEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class NoRegionsEvidence(Answer):
    """Regions that were looked for."""

    digest: str
    """Digest of the scene's content."""
    group: str
    """Group that the regions are for."""
    margin: float
    """Least margin that the regions keep [m]."""
    there: list[dict[str, Any]]
    """Regions that there are, and why they do not fit."""
    scene: str | None = None
    """Id of the scene."""


class NoRegionsProblem(Answer):
    """No regions fit the plan."""

    code: Literal["no_regions"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: NoRegionsEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class NoTrajectoryEvidence(Answer):
    """State of a plan that has no motion."""

    failure: dict[str, Any] | None = None
    """Reason why it has no motion, if it ended without one."""
    id: str | None = None
    """Id of the plan."""
    state: MotionlessState | None = None
    """State of the plan."""


class NoTrajectoryProblem(Answer):
    """The plan has no trajectory (yet)."""

    code: Literal["no_trajectory"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: NoTrajectoryEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class NotCertifiedFailure(Answer):
    """No candidate motion passed the certifier."""

    code: Literal["not_certified"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: CertificateEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class NotCertifiedProblem(Answer):
    """No candidate motion passed the certifier."""

    code: Literal["not_certified"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: CertificateEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class NotFoundFailure(Answer):
    """There is nothing of that id."""

    code: Literal["not_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: UnknownResourceEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class NotFoundProblem(Answer):
    """There is nothing of that id."""

    code: Literal["not_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: UnknownResourceEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class NotReadyProblem(Answer):
    """Workers are not warm yet, or cannot be."""

    code: Literal["not_ready"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: ReadinessEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class ObjectDocument(Answer):
    """An obstacle, or an object to handle."""

    name: str
    """Name of its body and of its frame."""
    shape: ShapeDocument
    """Geometry of the object [m]."""
    attached: AttachmentDocument | None = None
    """Its attachment to a robot; none if it is fixed to the world."""
    center_of_mass: list[float] | None = None
    """Center of mass in its frame [m]; none for that of the shape; only with `mass`."""
    color: list[float] | None = None
    """RGB or RGBA, each 0 to 1."""
    mass: float | None = None
    """Its mass while it is attached [kg]; none for no mass. Its inertia is that of the shape at
    uniform density; a mesh counts as its convex hull."""
    movable: bool = False
    """Whether it may be attached."""
    pose: PoseDocument | None = None
    """X_WO; of an attached object X_FO, in its frame."""


class ObjectiveValues(Answer):
    """Costs of one motion by each objective."""

    duration: float
    """Duration of the motion [s]."""
    energy: float | None
    """Integral over time of squared torques and forces [N^2 m^2 s]; null for groups with a
    floating joint."""
    path_length: float
    """Joint-space length [rad or m]."""
    smoothness: float | None
    """Integral over time of squared accelerations [rad^2/s^3], or of jerks if the objective
    says so [rad^2/s^5]; null where accelerations jump, so that jerks are infinite."""


class Orientation(Answer):
    """An axis of a frame stays within an angle of a direction; turns about the axis are free."""

    axis: list[float]
    """Axis in that frame; any length but zero."""
    direction: list[float]
    """Direction in `reference`; any length but zero."""
    frame: str
    """Frame whose axis is meant."""
    tolerance: float
    """Largest angle between them [rad]."""
    type: Literal["orientation"]
    """Kind of constraint."""
    reference: str = "world"
    """Frame in whose axes `direction` is given; a frame that moves counts as the start has it."""


class OriginEvidence(Answer):
    """Origin of the page that asked."""

    origin: str
    """Origin in the request."""


class OriginNotAllowedProblem(Answer):
    """A web page of another origin asks."""

    code: Literal["origin_not_allowed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: OriginEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class OtherFailure(Answer):
    """A failure that an older or a newer version recorded."""

    code: str
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: dict[str, Any]
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class OtherProblem(Answer):
    """A problem that a newer version tells."""

    code: str
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: dict[str, Any]
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Pair(Answer):
    """Two bodies and how near they are."""

    bodies: tuple[str, str]
    """Full names."""
    depth: float
    """Depth of penetration [m]; 0 if they do not touch."""
    distance: float
    """Signed distance [m]; negative is the depth of penetration."""
    points: list[list[float]]
    """Nearest point of each body, in world [m]."""


class PairsEvidence(Answer):
    """Pairs of bodies at the start."""

    pairs: list[ViolatingPair]
    """Pairs that overlap or violate their margin."""


class Parameter(Answer):
    """A parameter of a planner."""

    default: str
    """Its value if it is not given, as text."""
    maximum: float | None
    """Greatest value, or null where there is none."""
    minimum: float | None
    """Least value, or null where there is none."""
    name: str
    """OMPL's name."""
    range: str
    """The values that it may have, for a person."""
    type: Literal["boolean", "integer", "number"] | str
    """JSON type of its values."""


class Part(Answer):
    """A part of the motion, from rest to rest."""

    begin: float
    """First instant [s]."""
    end: float
    """Last instant [s]."""
    kind: Literal["free", "approach", "retreat", "line"] | str
    """Purpose of the part; all but `free` are straight lines of the tool."""
    length: float
    """Length of the tool's path [m]."""
    num_waypoints: int
    """Number of waypoints of its part of `path`, both ends included."""


class PartialPose(Answer):
    """A configuration that keeps the rest of the pose."""

    error: float
    """Error of the position [m] or of the rotation [rad]."""
    pose_index: int
    """Index of the goal's pose, from 0."""
    positions: list[float]
    """The group's positions [rad or m]."""


class PathBlockedEvidence(Answer):
    """Part of a motion that does not hold in the scene as it was edited."""

    check: str
    """Name of the failed check of the certificate."""
    fraction: float
    """Share of the path's length that lies before that place [0 to 1]."""
    pair: list[str]
    """Full names of both bodies, if it is about two."""
    revision: int
    """Revision of the scene that has the conflict."""
    time: float
    """Time along the motion [s]."""
    execution: str | None = None
    """Id of the execution whose motion is in the way, if the check is `beside`; else null."""


class PathBlockedFailure(Answer):
    """An edit of the scene blocks the rest of the motion."""

    code: Literal["path_blocked"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: PathBlockedEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class PathGoal(Answer):
    """Bring a tool frame through poses in straight lines, at rest at each."""

    poses: list[Pose]
    """Poses in this order; frames that move count where the start puts them."""
    type: Literal["path"]
    """Kind of goal."""
    deviation: Deviation | None = None
    """Largest deviation of the motion from the lines, between samples too."""
    frame: str | None = None
    """The tool frame: any that the group moves; null for its default."""


class Payload(Answer):
    """A rigid mass that follows a frame and burdens every joint that carries it."""

    frame: str
    """Frame that the mass follows; the group must move it."""
    mass: float
    """Mass [kg]."""
    center_of_mass: list[float] = Field(default=[0.0, 0.0, 0.0], validate_default=True)
    """Center of mass in the frame [m]."""
    inertia: list[float] = Field(default=[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], validate_default=True)
    """Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of mass, along the frame's axes [kg m^2];
    zeros for a point mass."""


class PlainPose(Answer):
    """A pose in world."""

    position: list[float]
    """Position x, y, z [m]."""
    quaternion: list[float]
    """Rotation w, x, y, z."""


class Plan(ShownPlan):
    """A plan; poll it until its state is final."""

    attempts: int
    """Number of times that a worker has begun with it, this one included; more than 1 where a
    worker or the server ended under it."""
    batch: str | None
    """Id of its batch; null for none."""
    cancel_requested_at: datetime | None
    """Time of the first request to end it (UTC), whatever came of it; null if there was none,
    or if the version did not record it."""
    created_at: datetime
    """Time of the request (UTC)."""
    digest: str | None
    """sha256 over the delivered numbers."""
    failure: Failure | None
    """Reason why there is no result."""
    finished_at: datetime | None
    """Time at which it ended (UTC)."""
    id: str
    """Id of the plan."""
    progress: float
    """Share of the whole plan, 0 to 1; within a stage it grows with the used share of the
    allowed time. A plan that failed or was canceled keeps the share that it reached."""
    request: PlanRequest
    """The request with its defaults, and the scene's latest `revision` and the newest
    `search.regions` where they were left open. Posted again, it gives the same plan."""
    result: PlanResult | None
    """Result of the plan, once it succeeded."""
    seed: int
    """Seed of all randomness."""
    stage: AnyStage
    """The stage that it is in or ended in, or empty."""
    started_at: datetime | None
    """Time at which a worker took it (UTC)."""
    state: JobState
    """State of the plan; succeeded, failed, canceled are final."""
    timings: Timings
    """Seconds per stage, once it has ended; of a failure those of `failure` [s]."""
    unrecorded: list[str]
    """Facts that the database does not hold yet, because it is full, locked or away: `cancel`,
    `controls`, `events`, `end`. They are written as soon as possible; requests are carried out
    all the same."""
    versions: Versions
    """Versions of everything that the numbers depend on, in the server that ran it last; empty
    before it runs, and for plans of versions that did not keep it."""
    best: BestPath | None = None
    """The best path of the search so far, while the plan runs; null before one is found, and
    once the plan has ended."""


class PlanPage(Answer):
    """Plans, newest first."""

    items: list[PlanSummary]
    """Plans on this page, without their results."""
    next: str | None
    """Cursor of the next page; null on the last one."""


class PlanRequest(Answer):
    """Move a group of a scene from a start to a goal."""

    goal: Goal
    """Goal of the motion."""
    group: str | list[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    scene: str
    """Id of a scene."""
    certify: Certify | None = None
    """Computations besides the proof."""
    ik: Ik | None = None
    """Options of the goals stage."""
    margin: float | None = None
    """Distance that everything keeps [m]; null for the scene's."""
    path_constraints: list[Constraint] = Field(default=[], validate_default=True)
    """Constraints that the whole motion shall keep, all of them; each has a check of its own in
    the certificate."""
    priority: Priority = "normal"
    """Priority among the jobs that wait; clients take turns within it. A job that has waited
    for 30 s goes with the next priority: `low` is delayed by others, never for good."""
    refine: Refine | None = None
    """Options of the refinement."""
    retime: Retime | None = None
    """Options of the timing."""
    revision: int | None = None
    """Revision of the scene; null for its latest."""
    search: Search | None = None
    """Options of the search."""
    seed: int = 0
    """Seed of all randomness: the same seed gives the same bytes."""
    start: list[float] | None = None
    """The group's positions [rad or m]; null for the scene's current state."""


class PlanResult(Answer):
    """Result of a solved problem; `?include=` leaves out `path, trajectory, certificate,
    stages`. A part that is left out is absent. Without `include` all are there."""

    digest: str
    """sha256 over the delivered numbers."""
    goal_configuration: list[float]
    """Configuration at which the motion reaches the goal: its end, except with a retreat [rad
    or m]."""
    goal_index: int
    """Index of the goal's candidate that it is, from 0."""
    start: list[float]
    """Configuration at which it starts, clipped into the limits [rad or m]."""
    start_clipped: list[float]
    """Change of the given start by clipping, at most 1e-6 [rad or m]."""
    certificate: Certificate | None = None
    """The proof."""
    cut_short: list[CutStage] | None = None
    """Stages that ended early because of the clock, by their names in `timings`; their results
    may be different another time. Empty if the same request gives the same numbers again,
    except `timings`; null if made by a version that did not record it."""
    parts: list[Part] = Field(default=[], validate_default=True)
    """The free motion and the straight lines it is made of, in order."""
    path: list[list[float]] | None = None
    """Untimed waypoints, one row each [rad or m]."""
    stages: Stages | None = None
    """Reports of all stages."""
    trajectory: Trajectory | None = None
    """The timed motion, sampled as `retime` says."""


class PlanSummary(Answer):
    """A plan without its result."""

    attempts: int
    """Number of times that a worker has begun with it, this one included; more than 1 where a
    worker or the server ended under it."""
    batch: str | None
    """Id of its batch; null for none."""
    cancel_requested_at: datetime | None
    """Time of the first request to end it (UTC), whatever came of it; null if there was none,
    or if the version did not record it."""
    created_at: datetime
    """Time of the request (UTC)."""
    digest: str | None
    """sha256 over the delivered numbers."""
    failure: Failure | None
    """Reason why there is no result."""
    finished_at: datetime | None
    """Time at which it ended (UTC)."""
    id: str
    """Id of the plan."""
    progress: float
    """Share of the whole plan, 0 to 1; within a stage it grows with the used share of the
    allowed time. A plan that failed or was canceled keeps the share that it reached."""
    request: PlanRequest
    """The request with its defaults, and the scene's latest `revision` and the newest
    `search.regions` where they were left open. Posted again, it gives the same plan."""
    seed: int
    """Seed of all randomness."""
    stage: AnyStage
    """The stage that it is in or ended in, or empty."""
    started_at: datetime | None
    """Time at which a worker took it (UTC)."""
    state: JobState
    """State of the plan; succeeded, failed, canceled are final."""
    timings: Timings
    """Seconds per stage, once it has ended; of a failure those of `failure` [s]."""
    unrecorded: list[str]
    """Facts that the database does not hold yet, because it is full, locked or away: `cancel`,
    `controls`, `events`, `end`. They are written as soon as possible; requests are carried out
    all the same."""
    versions: Versions
    """Versions of everything that the numbers depend on, in the server that ran it last; empty
    before it runs, and for plans of versions that did not keep it."""
    best: BestPath | None = None
    """The best path of the search so far, while the plan runs; null before one is found, and
    once the plan has ended."""


class Planner(Answer):
    """A planner that a plan may name."""

    name: str
    """Name of the planner in OMPL, or `GCS`."""
    needs_regions: bool
    """Whether it plans inside regions, see POST /v1/scenes/{id}/regions."""
    parameters: list[Parameter]
    """Parameters that can be set."""


class PlannerGraph(Answer):
    """Graph that a planner explored: trees or a roadmap, at most the first 2,000 vertices of
    it."""

    edges: list[tuple[int, int]]
    """Pairs of rows that motions join."""
    goals: list[int]
    """Rows of goals."""
    num_edges: int
    """Number of pairs, those left out included."""
    num_vertices: int
    """Number of vertices, those left out included."""
    path: list[int]
    """Rows of the solution as the planner found it, before shortcutting, in order; empty if it
    found none."""
    planner: str
    """Name of the planner in OMPL; empty where a straight line was free."""
    starts: list[int]
    """Rows of starts."""
    vertices: list[list[float]]
    """The group's positions, a row each [rad or m]."""


class PlannerList(Answer):
    """All planners."""

    items: list[Planner]
    """Planners, sorted by name."""


class Polynomial(Answer):
    """The exact motion: q(t) = bases[i] [+] sum_k coefficients[i][k] (t - breaks[i])^k. It
    holds on breaks[i] <= t <= breaks[i + 1]. `[+]` is the plain sum, but for floating joints,
    where the first three tangent coordinates turn the quaternion: R exp(delta)."""

    bases: list[list[float]]
    """Configuration at which each piece is anchored, n rows [rad or m]."""
    breaks: list[float]
    """Instants between pieces, n + 1 of them [s]."""
    coefficients: list[list[list[float]]]
    """n pieces, powers k from 0 up, a column per velocity coordinate [rad/s^k or m/s^k]."""
    joint_names: list[str]
    """A name per position coordinate."""
    joint_types: list[str]
    """A type per joint: revolute, continuous, prismatic, planar or floating."""


class Portal(Answer):
    """Overlap of two regions."""

    point: list[float]
    """Center of the largest ball in both [rad or m]."""
    radius: float
    """Radius of that ball [rad or m]."""
    regions: tuple[int, int]
    """Indices of the two in the list of regions."""


class Pose(Answer):
    """A rigid transform in a frame; `quaternion` or `rpy`, or neither for no rotation."""

    position: list[float]
    """x, y, z in `frame` [m]."""
    frame: str = "world"
    """The frame that the pose is given in: any frame of the scene."""
    quaternion: list[float] | None = None
    """Rotation as [w, x, y, z]; normalised when read, never zero."""
    rpy: list[float] | None = None
    """Rotation as roll, pitch, yaw about fixed x, y, z [rad]."""


class PoseDistanceTolerance(Answer):
    """All poses within a weighted distance: sqrt(sum (w_i * way_i)^2 + (w_r * angle)^2)."""

    tolerance: float
    """The largest distance [1]."""
    frame: str | None = None
    """Frame in whose axes the way from the target's origin is measured, as they stand at the
    start: any frame; null for the target's own."""
    weights: list[float] = Field(default=[1.0, 1.0, 1.0, 0.1], validate_default=True)
    """w_x, w_y, w_z [1/m] and w_r [1/rad]; what has no weight is free."""


class PoseDocument(Answer):
    """A rigid transform; `quaternion` or `rpy`, or neither for no rotation."""

    position: list[float] = Field(default=[0.0, 0.0, 0.0], validate_default=True)
    """x, y, z [m]."""
    quaternion: list[float] | None = None
    """[w, x, y, z], any length > 0."""
    rpy: list[float] | None = None
    """roll, pitch, yaw about fixed axes [rad]."""


class PoseGoal(Answer):
    """Bring a tool frame to a pose, or to any of several."""

    poses: list[Pose]
    """The candidates; `goal_index` of the result says which one was reached."""
    type: Literal["pose"]
    """Kind of goal."""
    approach: list[float] | None = None
    """Displacement of the tool, in the target's axes, at which the last straight line to the
    goal begins [m]; the tool does not turn on it; null for none."""
    frame: str | None = None
    """The tool frame: any that the group moves; null for its default."""
    metric: PoseDistanceTolerance | None = None
    """Tolerance by a weighted metric, instead of `tolerance`."""
    retreat: list[float] | None = None
    """Displacement of the tool, in the target's axes, in a straight line after the goal [m];
    null for none."""
    tolerance: Tolerance | None = None
    """Tolerance of the pose."""


class PoseMetric(Answer):
    """Distance of two poses: sqrt((translation * t)^2 + (rotation * angle)^2)."""

    rotation: float = 0.1
    """Weight of a radian [1/rad]; by default one weighs as much as 0.1 m."""
    translation: float = 1.0
    """Weight of a metre [1/m]."""


class Position(Answer):
    """The origin of a frame stays near a line, a plane or a point."""

    frame: str
    """Frame whose origin is meant."""
    size: list[float | None]
    """Width of the band along each axis of `pose` [m]; null for an axis that is free: one
    number is a plane, two are a line."""
    type: Literal["position"]
    """Kind of constraint."""
    pose: Pose | None = None
    """Pose of its middle; in a frame that moves with the group, as the start puts it."""


type Priority = Literal["low", "normal", "high"] | str
"""Priority among the jobs that wait."""

type Problem = Annotated[
    Annotated[
        HttpErrorProblem
        | SceneInvalidProblem
        | SceneEditImpossibleProblem
        | AssetNotFoundProblem
        | ModelInvalidProblem
        | ProblemInvalidProblem
        | UnknownNameProblem
        | StartInCollisionProblem
        | StartTooNearProblem
        | StartOutOfLimitsProblem
        | StartViolatesConstraintProblem
        | GoalOutOfLimitsProblem
        | GoalInCollisionProblem
        | GoalTooNearProblem
        | GoalUnreachableProblem
        | GoalViolatesConstraintProblem
        | ApproachBlockedProblem
        | LineBlockedProblem
        | NoPathFoundProblem
        | DeadlineExceededProblem
        | CanceledProblem
        | RetimingFailedProblem
        | ScheduleNotFoundProblem
        | GraspMissedProblem
        | NotCertifiedProblem
        | IllegalTransitionProblem
        | WorkerCrashedProblem
        | WorkerUnresponsiveProblem
        | HostLostProblem
        | MemoryLimitExceededProblem
        | InternalErrorProblem
        | QueueFullProblem
        | QueueTimeoutProblem
        | IdempotencyConflictProblem
        | ResourceInUseProblem
        | UnknownJobProblem
        | DatabaseTakenProblem
        | DatabaseUnavailableProblem
        | UnreadableBodyProblem
        | UnauthorizedProblem
        | ScopeMissingProblem
        | HostNotAllowedProblem
        | OriginNotAllowedProblem
        | RequestTimeoutProblem
        | NotFoundProblem
        | AddressNotAllowedProblem
        | MethodNotAllowedProblem
        | NotReadyProblem
        | WrongJointCountProblem
        | NoTrajectoryProblem
        | NoRegionsProblem
        | StartMismatchProblem
        | RobotBusyProblem
        | RobotStateUnknownProblem
        | RevisionConflictProblem
        | RevisionMismatchProblem
        | SceneNotKeptProblem
        | BodyTooLargeProblem
        | UnsupportedMediaTypeProblem
        | RequestInvalidProblem
        | RateLimitedProblem
        | DiskFullProblem
        | ServerStoppingProblem,
        Field(discriminator="code"),
    ]
    | OtherProblem,
    Field(union_mode="left_to_right"),
]
"""Reason why a request was refused (`application/problem+json`, RFC 9457). Its `code` says what
its `evidence` has."""


class ProblemError(Answer):
    """One thing that is wrong with a request, and where."""

    message: str
    """What is wrong there, for a person."""
    nearest: list[str]
    """Names or values that were perhaps meant, the nearest first."""
    pointer: str
    """JSON pointer into the body; empty for its root and for parameters."""
    parameter: str = ""
    """Name of the parameter of the query, the path or the headers that is wrong; absent where
    the body is."""


class ProblemFieldEvidence(Answer):
    """Field of a request that is wrong; other members say what is in its way."""

    field: str
    """Place of the field in the request, as names and numbers with dots."""


class ProblemInvalidFailure(Answer):
    """A planning problem has a fault."""

    code: Literal["problem_invalid"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: ProblemFieldEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class ProblemInvalidProblem(Answer):
    """A planning problem has a fault."""

    code: Literal["problem_invalid"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: ProblemFieldEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class ProgressData(Answer):
    """Progress of a job."""

    at: datetime
    """Time at which it happened (UTC)."""
    detail: str
    """Text for a person, or empty."""
    progress: float
    """Share of the whole job, 0 to 1."""
    stage: Stage
    """The stage that it is in."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""


class ProgressEvent(Answer):
    """The job is further, at most twenty times a second."""

    data: Json[ProgressData]
    """Progress of the job."""
    event: Literal["progress"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class QueueFullEvidence(Answer):
    """Number of jobs in a queue that is full."""

    bound: int
    """Number of jobs that may wait."""
    queue: QueueName
    """Name of the queue."""
    retry_after: float
    """Time after which to ask again [s]."""
    queued: int | None = None
    """Number of jobs that wait."""


class QueueFullProblem(Answer):
    """A queue has as many waiting jobs as it may."""

    code: Literal["queue_full"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: QueueFullEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


type QueueName = Literal["plan", "query", "execution", "regions"] | str
"""Queues of jobs and questions."""


class QueueTimeoutEvidence(Answer):
    """Time that a question waited for a worker."""

    queue: QueueName
    """Name of the queue."""
    queued: int
    """Number of questions that wait there."""
    retry_after: float
    """Time after which to ask again [s]."""
    waited: float
    """Time that the question waited [s]."""


class QueueTimeoutProblem(Answer):
    """No worker was free in time."""

    code: Literal["queue_timeout"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: QueueTimeoutEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class QueuedEvent(Answer):
    """The job was accepted."""

    data: Json[EventData]
    """Time of the event."""
    event: Literal["queued"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class RateEvidence(Answer):
    """Number of requests that a caller may make."""

    limit: str
    """Limit in the server's settings, such as `600/minute`."""
    retry_after: float
    """Time after which to ask again [s]."""


class RateLimitedProblem(Answer):
    """The caller has made too many requests."""

    code: Literal["rate_limited"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: RateEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Readiness(Answer):
    """Whether the server takes jobs."""

    queued: dict[str, int]
    """Jobs that wait, by queue."""
    role: Literal["leader", "follower"] | str
    """Role among the servers of its database: the leader runs the jobs of all; one server alone
    is the leader."""
    running: dict[str, int]
    """Jobs that run, by queue."""
    status: Literal["ready"]
    """Always `ready`; else the answer is 503."""


class ReadinessEvidence(Answer):
    """Why the server is not ready."""

    faults: dict[str, str] | None = None
    """Reason why no worker is ready, by kind of work."""
    retry_after: float | None = None
    """Time after which to ask again [s]."""


class Refine(Answer):
    """Options for optimising the path."""

    clearance: ClearanceObjective | None = None
    """Clearance that the duration is weighed against; `none` and `drake` have no use for it."""
    method: Literal["trajopt", "drake", "auto", "none"] | str = "trajopt"
    """Method: convex steps (`trajopt`), Drake's KinematicTrajectoryOptimization (`drake`), as
    `trajopt` but only if at least half a second is left (`auto`), or none, which leaves the
    path as it is."""
    objective: RefineObjective | None = None
    """Objective to minimise; null for the duration, the only objective for cars. With it, or
    with `drake`, the report has all objectives, before and after."""


class RefineObjective(Answer):
    """Objective to minimise: a weighted sum; at least one weight is positive."""

    derivative: Literal["acceleration", "jerk"] | str = "acceleration"
    """Derivative that smoothness integrates."""
    duration: float = 0.0
    """Weight of the duration [1/s]."""
    energy: float = 0.0
    """Weight of the integral over time of the squared norm of the joints' torques and forces,
    gravity, damping and payload included [1/(N^2 m^2 s)]; not for groups with a floating joint."""
    max_duration: float | None = None
    """Longest duration of the motion [s], approach and retreat not counted; less than the
    limits allow is `retiming_failed`. Smoothness and energy need it unless the duration has a
    weight."""
    path_length: float = 0.0
    """Weight of the joint-space length [1/rad or 1/m]."""
    smoothness: float = 0.0
    """Weight of the integral over time of the squared norm of what `derivative` names
    [s^3/rad^2, for jerk s^5/rad^2]."""


class RefineReport(Answer):
    """Report of the refine stage."""

    duration_after: float
    """Estimate for the solution [s]."""
    duration_before: float
    """Estimate for the initial guess [s]."""
    improved: bool
    """Whether the refined curve is what was delivered."""
    length_after: float
    """Length of the refined curve [rad or m]."""
    length_before: float
    """Length of the path [rad or m]."""
    lower_bound: float
    """Time that the slowest joint alone takes from start to goal [s]; nothing is quicker."""
    method: Literal["trajopt", "drake", "auto", "none"] | str
    """Method that was requested."""
    reason: str
    """Reason why it was not delivered, or empty."""
    rounds: int
    """Number of steps tried, each a convex program; of `drake` nonlinear programs."""
    solver: RefineSolver
    """Name of the solver, or empty."""
    after: ObjectiveValues | None = None
    """Objectives of the motion that is delivered; null as for `before`."""
    before: ObjectiveValues | None = None
    """Objectives of the motion along the path as the search left it, as quick as the limits
    allow; null unless the request states an objective or the method is `drake`."""
    shortfall: float | None = None
    """Shortfall of the clearance from the preferred one, on average over the motion [m]; null
    if none was preferred or nothing was refined."""


type RefineSolver = Literal["interior point", "Clarabel", "SNOPT", ""] | str
"""Solvers of refinement, or none."""

type RefusedEvent = (
    Literal[
        "start",
        "succeed",
        "fail",
        "cancel",
        "requeue",
        "pause",
        "resume",
        "set_speed",
        "stopped",
        "lose",
        "steer",
        "delete",
    ]
    | str
)
"""Events of jobs and executions."""

type RefusingState = (
    Literal[
        "queued",
        "running",
        "succeeded",
        "failed",
        "canceled",
        "accepted",
        "executing",
        "paused",
        "canceling",
        "aborting",
        "aborted",
        "at its end",
    ]
    | str
)
"""States of jobs and executions that refuse an event."""


class Region(Answer):
    """A region: those configurations q with normals q <= offsets."""

    center: list[float]
    """A configuration well inside [rad or m]."""
    normals: list[list[float]]
    """Unit normals of its faces, a row each."""
    num_free: int
    """Number of consecutive random configurations that were free: with 95 % confidence less
    than 3 / num_free of its volume collides."""
    offsets: list[float]
    """Offset of each face [rad or m]."""


class RegionGoal(Answer):
    """Bring a tool frame anywhere into a region, or into any of several."""

    type: Literal["region"]
    """Kind of goal."""
    approach: list[float] | None = None
    """Displacement of the tool, in the region's axes, at which the last straight line to the
    motion's end in the region begins [m]; null for none."""
    frame: str | None = None
    """The tool frame: any that the group moves; null for its default."""
    free_axes: list[Literal["x", "y", "z", "rx", "ry", "rz"] | str] = Field(
        default=[], validate_default=True
    )
    """Axes of the region that it is unbounded along (`x`, `y`, `z`: as far as the group
    reaches) or free to turn about (`rx`, `ry`, `rz`)."""
    pose: Pose | None = None
    """Middle of the only region."""
    poses: list[Pose] | None = None
    """Middles of the regions; or one as `pose`."""
    retreat: list[float] | None = None
    """Displacement of the tool, in the region's axes, in a straight line after the goal [m];
    null for none."""
    tolerance: Tolerance | None = None
    """Extent of the region from its middle, by its axes."""


class RegionsBrief(Answer):
    """A request for regions and its state, without faces."""

    attempts: int
    """Number of times that a worker has begun with it, this one included; more than 1 where a
    worker or the server ended under it."""
    cancel_requested_at: datetime | None
    """Time of the first request to end it (UTC), whatever came of it; null if there was none,
    or if the version did not record it."""
    created_at: datetime
    """Time of the request (UTC)."""
    failure: Failure | None
    """Reason why there is no result."""
    finished_at: datetime | None
    """Time at which it ended (UTC)."""
    id: str
    """Id of the regions."""
    progress: float
    """Share of the work that is done, 0 to 1."""
    request: RegionsRequest
    """The request, defaults filled in."""
    revision: int
    """Revision of the scene."""
    scene: str
    """Id of the scene."""
    stage: AnyStage
    """Stage that it is in, `load` or `regions`, or empty."""
    started_at: datetime | None
    """Time at which a worker began (UTC)."""
    state: JobState
    """State of the growth; succeeded, failed and canceled are final."""
    summary: RegionsSummary | None
    """The regions without their faces, once it succeeded."""
    timings: Timings
    """Seconds per stage, once it has ended; of a failure those of `failure` [s]."""
    unrecorded: list[str]
    """Facts that the database does not hold yet, because it is full, locked or away: `cancel`,
    `controls`, `events`, `end`. They are written as soon as possible; requests are carried out
    all the same."""
    versions: Versions
    """Versions of everything that the numbers depend on, in the server that ran it last; empty
    before it runs, and for regions of versions that did not keep it."""


class RegionsJob(Answer):
    """A request for regions with its result; poll it until its state is final."""

    attempts: int
    """Number of times that a worker has begun with it, this one included; more than 1 where a
    worker or the server ended under it."""
    cancel_requested_at: datetime | None
    """Time of the first request to end it (UTC), whatever came of it; null if there was none,
    or if the version did not record it."""
    created_at: datetime
    """Time of the request (UTC)."""
    failure: Failure | None
    """Reason why there is no result."""
    finished_at: datetime | None
    """Time at which it ended (UTC)."""
    id: str
    """Id of the regions."""
    progress: float
    """Share of the work that is done, 0 to 1."""
    request: RegionsRequest
    """The request, defaults filled in."""
    result: RegionsResult | None
    """The regions, once it succeeded."""
    revision: int
    """Revision of the scene."""
    scene: str
    """Id of the scene."""
    stage: AnyStage
    """Stage that it is in, `load` or `regions`, or empty."""
    started_at: datetime | None
    """Time at which a worker began (UTC)."""
    state: JobState
    """State of the growth; succeeded, failed and canceled are final."""
    summary: RegionsSummary | None
    """The regions without their faces, once it succeeded."""
    timings: Timings
    """Seconds per stage, once it has ended; of a failure those of `failure` [s]."""
    unrecorded: list[str]
    """Facts that the database does not hold yet, because it is full, locked or away: `cancel`,
    `controls`, `events`, `end`. They are written as soon as possible; requests are carried out
    all the same."""
    versions: Versions
    """Versions of everything that the numbers depend on, in the server that ran it last; empty
    before it runs, and for regions of versions that did not keep it."""


class RegionsPage(Answer):
    """Regions, newest first."""

    items: list[RegionsBrief]
    """Regions on this page, without their faces."""
    next: str | None
    """Cursor of the next page; null on the last one."""


class RegionsReport(Answer):
    """Use of regions in a search."""

    considered: list[int]
    """Places, in the list of regions, of those that the path was looked for in."""
    digest: str
    """Digest of the regions, whose id is `search.regions` of the plan's `request`."""
    fallback: str
    """Reason why it did not, or empty."""
    is_inside: bool
    """Whether the path came from them."""
    num_regions: int
    """Number of regions."""


class RegionsRequest(Answer):
    """Grow regions for a group of a scene."""

    group: str | list[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    allowed_time: float = 600.0
    """Time after which the regions that have grown are the result [s]."""
    along: Literal["paths", "nothing"] | str = "paths"
    """Regions that come first: those along paths from the scene's state to the group's named
    configurations and the scene's frames (`paths`), or none but the cover (`nothing`)."""
    bounds: dict[str, list[float]] = Field(default={}, validate_default=True)
    """Lowest and highest value to grow in [rad or m], by position name, within the limits;
    angles that may turn further are taken from -pi to pi, those on a circle over one turn at
    most."""
    coverage: float = 0.9
    """Coverage at which growth ends, as a share of the free configurations in the domain [1]."""
    iterations: int = 3
    """Number of times that a region is grown anew around its largest ellipsoid."""
    margin: float | None = None
    """Distance that regions keep [m]; null for the scene's."""
    num_free: int = 5000
    """Number of consecutive random configurations of a region that must be free."""
    num_regions: int = 60
    """Largest number of regions."""
    padding: float = 0.001
    """Distance beyond the margin, for proofs to be quick [m]."""
    priority: Priority = "normal"
    """Priority among the jobs that wait; clients take turns within it. A job that has waited
    for 30 s goes with the next priority: `low` is delayed by others, never for good."""
    revision: int | None = None
    """Revision of the scene; null for its latest."""
    seed: int = 0
    """Seed of all randomness: the same seed gives the same regions."""


class RegionsResult(Answer):
    """Regions that were grown, with their faces."""

    coverage: float
    """Share of the domain's free configurations that some region holds, by sampling."""
    coverage_error: float
    """Standard error of `coverage`."""
    digest: str
    """sha256 over all numbers of the regions."""
    group: str
    """Group of the configurations."""
    lower: list[float]
    """Lowest configuration of the domain [rad or m]."""
    margin: float
    """Distance that they keep [m]."""
    num_portals: int
    """Number of pairs of regions that overlap."""
    num_regions: int
    """Number of regions."""
    portals: list[Portal]
    """Overlaps of the regions."""
    regions: list[Region]
    """Regions in the order in which they were grown."""
    scene: str
    """Digest of the scene in which they are free of collision."""
    seed: int
    """Seed of all randomness."""
    stopped_by: RegionsStopReason
    """Reason why there are no more: `coverage`, `num_regions`, `deadline` or `exhausted`."""
    upper: list[float]
    """Highest configuration of the domain [rad or m]."""


type RegionsStopReason = Literal["coverage", "num_regions", "deadline", "exhausted"] | str
"""Reason why there are no more regions."""


class RegionsSummary(Answer):
    """Regions that were grown, without their faces."""

    coverage: float
    """Share of the domain's free configurations that some region holds, by sampling."""
    coverage_error: float
    """Standard error of `coverage`."""
    digest: str
    """sha256 over all numbers of the regions."""
    group: str
    """Group of the configurations."""
    lower: list[float]
    """Lowest configuration of the domain [rad or m]."""
    margin: float
    """Distance that they keep [m]."""
    num_portals: int
    """Number of pairs of regions that overlap."""
    num_regions: int
    """Number of regions."""
    scene: str
    """Digest of the scene in which they are free of collision."""
    seed: int
    """Seed of all randomness."""
    stopped_by: RegionsStopReason
    """Reason why there are no more: `coverage`, `num_regions`, `deadline` or `exhausted`."""
    upper: list[float]
    """Highest configuration of the domain [rad or m]."""


class RejectedPair(Answer):
    """Number of configurations that were rejected with one pair as the deepest collision."""

    bodies: tuple[str, str]
    """Full names of both bodies."""
    count: int
    """Number of configurations."""
    max_depth: float
    """Largest depth of the collision among them [m]."""
    min_depth: float
    """Least depth of the collision among them [m]."""


class RejectedSamples(Answer):
    """Why some samples are no goal configurations."""

    bodies: tuple[str, str] | None
    """The deepest pair of collisions; null where it was not measured."""
    count: int
    """Number of samples."""
    max_depth: float | None
    """The largest depth among them [m]."""
    min_depth: float | None
    """The least depth among them [m]."""
    reason: SampleRejection
    """Test that they failed."""
    share: float
    """Share of all samples that were tried [0 to 1]."""


class Rejection(Answer):
    """Why some samples are no goal configurations."""

    bodies: tuple[str, str] | None
    """For `collision`, the deepest pair; null for samples that time was too short to measure."""
    count: int
    """Number of samples; with `distinct` the counts add up to `tried`."""
    max_depth: float | None
    """Largest depth among them [m]."""
    min_depth: float | None
    """Smallest depth among them [m]."""
    reason: SampleRejection
    """Test that they failed."""
    share: float
    """Share of `tried`, 0 to 1."""


class RelativeGoal(Answer):
    """Move a tool frame by a displacement from where the start has it."""

    displacement: Displacement
    """Displacement from where the tool is at the start."""
    type: Literal["relative"]
    """Kind of goal."""
    frame: str | None = None
    """The tool frame: any that the group moves; null for its default."""
    reference: str | None = None
    """Frame in whose axes, as they are at the start, the tool is shifted, and turned about its
    own origin; null for the tool frame itself."""


class RelaxedConstraint(Answer):
    """A path constraint whose change alone is sufficient."""

    bound: float | None
    """Present bound, in `unit`."""
    constraint: str
    """Its place in the request and its kind."""
    pose_index: int
    """Index of the goal's pose that is reached then, from 0."""
    positions: list[float]
    """The group's positions then [rad or m]."""
    unit: str
    """Unit of both bounds; `1` for a number without one."""
    value: float | None
    """The bound that is sufficient, in `unit`; null where it would have to be left out."""
    joint: str | None = None
    """Worst joint, for constraints on joints."""


class RemovedBody(Answer):
    """A body without which the goal is feasible."""

    body: str
    """Full name of the body."""
    pose_index: int
    """Index of the goal's pose that is reached then, from 0."""
    positions: list[float]
    """The group's positions then [rad or m]."""


class Replanned(Answer):
    """A plan that is carried out instead of the motion that was asked for."""

    code: str
    """Code that the execution would have been refused with."""
    detail: str
    """Reason of that refusal, for a person."""
    plan: str
    """Id of the plan."""


class RequestInvalidProblem(Answer):
    """The body or the parameters have faults."""

    code: Literal["request_invalid"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: FaultsEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class RequestTimeoutProblem(Answer):
    """The body did not arrive in time."""

    code: Literal["request_timeout"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: TimeoutEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class RequeuedData(Answer):
    """Why a job runs again."""

    at: datetime
    """Time at which it happened (UTC)."""
    reason: str
    """Text for a person."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""


class RequeuedEvent(Answer):
    """The job waits again: its worker or the server ended."""

    data: Json[RequeuedData]
    """Time and reason of the event."""
    event: Literal["requeued"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class ResourceInUseProblem(Answer):
    """A job that has not ended names this one."""

    code: Literal["resource_in_use"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: InUseEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


type ResourceKind = (
    Literal[
        "batch",
        "job",
        "mesh",
        "plan",
        "execution",
        "regions",
        "revision",
        "scene",
        "webhook",
        "robot",
    ]
    | str
)
"""Kinds of resources that may not exist."""


class RestartEvidence(Answer):
    """Number of times that the job was started."""

    attempts: int
    """Number of times that it was started."""
    during: str | None = None
    """The stage that it told last."""
    reason: str | None = None
    """Reason why the server ended it, if it did."""


class Retime(Answer):
    """Options for timing the path."""

    acceleration_bounds: dict[str, list[float]] = Field(default={}, validate_default=True)
    """Lowest (below 0) and highest (above 0) acceleration, by name of a joint with one
    coordinate, or `joint.angular` of a planar one [rad/s^2 or m/s^2]."""
    acceleration_scale: float = 1.0
    """Factor on every acceleration and jerk limit, 0..1."""
    deviation: float | None = None
    """Largest distance by which corners of the path may be rounded [rad or m, joint-space
    length]; 0 to follow the very path with a rest at every corner, null for at most 0.1.
    Refined paths have no corners."""
    duration: float | None = None
    """Duration of the motion [s]; null for the least that the limits allow, and less than that
    is `retiming_failed`."""
    effort: bool = False
    """Whether joint torques and forces must stay within their limits, gravity and all that is
    carried included: check `torque` of the certificate."""
    even_samples: bool = False
    """Whether to deliver samples exactly `sample_period` apart, but for the last, wherever the
    pieces of the motion meet; `trajectory.interpolations` says what is proven of them."""
    explain: bool = False
    """Whether to report which limit binds when, and what relaxing it would save
    (`stages.retime.explanation`), once the motion is proven and if there is time. It takes
    about 20 ms for each part; with ruckig as long as timing it once more for each limit that
    binds, six at most."""
    method: Literal["toppra", "ruckig"] | str = "toppra"
    """Method of timing: toppra keeps velocity and acceleration limits; ruckig keeps jerk limits
    too."""
    num_points: int | None = None
    """Number of samples to deliver, evenly in time however far apart, first and last instants
    included; null for one every `sample_period`, not both. `trajectory.interpolations` says
    what is proven of them."""
    payload: Payload | None = None
    """Mass that the group carries and the scene does not show; it counts for torques."""
    sample_period: float | None = 0.01
    """Longest time between delivered samples [s]; null where `num_points` says how many; more
    than 200000 samples are `problem_invalid`. They lie where the pieces of the motion meet, and
    evenly between, so that every interpolation of them can be proven."""
    speed_zones: list[SpeedZone] = Field(default=[], validate_default=True)
    """Boxes in which a frame is slower."""
    tool_limits: list[ToolLimit] = Field(default=[], validate_default=True)
    """Largest speeds and accelerations of frames."""
    velocity_scale: float = 1.0
    """Factor on every velocity limit, 0..1."""


class RetimeReport(Answer):
    """Report of the retime stage."""

    binding: dict[str, str]
    """Name of what is nearest its bound, per limit."""
    blend_deviation: float
    """Distance by which corners were rounded, or by which the smoothed curve may be off the
    path [rad or m]."""
    duration: float
    """Duration of the trajectory [s]."""
    method: Literal["toppra", "ruckig"] | str
    """Method that was requested."""
    slowed: float
    """Factor by which the audit stretched it [1]; 1 is not at all."""
    stops: int
    """Instants of rest between start and goal."""
    utilisation: dict[str, float]
    """Peak over limit, per limit [1]."""
    explanation: DurationExplanation | None = None
    """Explanation of the duration; null if not requested, or no time was left."""


class RetimeResponse(Answer):
    """A certified motion along the path, or why there is none."""

    certificate: Certificate | None
    """The proof; null if there is none."""
    failure: Failure | None
    """Reason why there is none: `not_certified` with the failed checks, `retiming_failed`,
    `deadline_exceeded`; null if there is one."""
    stages: RetimeStages | None
    """Reports of the stages; null if there is no motion."""
    trajectory: Trajectory | None
    """The motion; null if there is none."""
    cut_short: list[str] = Field(default=[], validate_default=True)
    """Stages that the clock ended early, whose results may differ another time: `retime`,
    `certify`, `explain`, `samples`."""


class RetimeStages(Answer):
    """Reports of the two stages."""

    certify: CertifyReport
    """Report of the proof."""
    retime: RetimeReport
    """Report of the timing."""


class RetimingEvidence(Answer):
    """Why the path has no timing."""

    at: float | None = None
    """Share of the path at which that is [0 to 1]."""
    bound: float | None = None
    """Torque or force that the joint may use [N m or N]."""
    duration: float | None = None
    """Duration that was requested [s]."""
    joints: list[str] | None = None
    """Joints of types that the method does not move."""
    least: float | None = None
    """Least duration that the limits allow [s]."""
    limit: str | None = None
    """Name of the limit that is too low."""
    method: RetimingMethod | None = None
    """Method of timing."""
    missed: float | None = None
    """Distance by which the method missed the end of the path [rad or m]."""
    num_cells: int | None = None
    """Number of pieces that the path was cut into."""
    num_grid_points: int | None = None
    """Number of points at which the path was sampled."""
    result: str | None = None
    """Result that the method reported."""
    stuck: list[str] | None = None
    """Joints that have to move, and may not because of that limit."""
    torque: float | None = None
    """Torque or force that gravity alone needs there [N m or N]."""
    where: str | None = None
    """Joint whose limit on torque is too low."""


class RetimingFailedFailure(Answer):
    """No timing of the path keeps the limits."""

    code: Literal["retiming_failed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: RetimingEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class RetimingFailedProblem(Answer):
    """No timing of the path keeps the limits."""

    code: Literal["retiming_failed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: RetimingEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


type RetimingMethod = Literal["toppra", "ruckig"] | str
"""Methods of timing."""


class RevisionConflictProblem(Answer):
    """The scene has moved on since."""

    code: Literal["revision_conflict"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: RevisionEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class RevisionEvidence(Answer):
    """Which revision the scene is at."""

    latest: int
    """Latest revision."""
    revision: int
    """Revision that the request names."""


class RevisionMismatchProblem(Answer):
    """The scene is not at the revision of `If-Match`."""

    code: Literal["revision_mismatch"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: EntityTagEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class Roadmap(Answer):
    """A roadmap that many plans share; it is built once for a scene as a group sees it."""

    neighbours: int = 12
    """Number of nearest others that each is joined with, where the way is free."""
    seed: int = 0
    """Seed of its samples; the plan's own seed does not change it."""
    states: int = 2000
    """Number of free configurations that it has."""


class RoadmapReport(Answer):
    """Use of a roadmap; the same whether it was built for this plan or there already."""

    digest: str
    """sha256 of its content."""
    num_edges: int
    """Number of free ways between them."""
    num_states: int
    """Number of its configurations."""
    num_states_checked: int
    """Number of configurations checked for collision to build it, whenever that was."""
    reason: (
        Literal[
            "",
            "straight_line",
            "start_not_joined",
            "goal_not_joined",
            "no_way",
            "blocked",
            "interrupted",
            "not_proven",
        ]
        | str
    )
    """Reason why it was not used, or empty: a straight line is better, no free way leads from
    the start or to a goal, none through it, its path is blocked on a closer look, the search
    ended before it answered, or its path was not proven."""
    used: bool
    """Whether the path that was kept is from the roadmap."""


class RobotBusyProblem(Answer):
    """An execution moves one of these robots, or waits for one."""

    code: Literal["robot_busy"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: BusyEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class RobotDocument(Answer):
    """A robot in the scene."""

    model: str
    """Name of a robot (GET /v1/models), or a path of a URDF, SDF or MJCF file."""
    name: str
    """Prefix of its bodies, frames and joints: `name::link`."""
    base: PoseDocument | None = None
    """X_WB, pose at which its base link is welded."""
    positions: str | list[float] | dict[str, float | list[float]] | None = None
    """Name of a configuration, values of its default group, or values by joint."""
    weld: bool | None = None
    """Whether its base link is welded to the world at `base`, or floats and starts there. By
    default bases of URDF files are welded, and those of SDF and MJCF files float unless they
    say otherwise themselves."""


class RobotState(Answer):
    """Present state of a robot."""

    execution: str | None
    """Execution that moves it, or waits to; null for none."""
    positions: JointPositions
    """Positions of the joints of its groups [rad or m]; `set_positions` takes them as they are."""
    robot: str
    """Name of the robot in the scene."""
    source: StateSource
    """Source of its positions."""
    status: RobotStatus
    """Status: `at_rest`; `moving`, by an execution; or `unknown`: an execution has ended
    without its driver, and nothing in the scene moves until `set_positions` says where the
    robot is."""
    updated_at: datetime
    """Time at which its source said so last (UTC)."""
    velocities: JointPositions | None
    """Measured velocities [rad/s or m/s]; null where its driver does not tell."""


class RobotStateEvidence(Answer):
    """Robots that have to be looked at."""

    robots: list[str]
    """Names of the robots."""


class RobotStateUnknownFailure(Answer):
    """It is not known where a robot of this scene is."""

    code: Literal["robot_state_unknown"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: RobotStateEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class RobotStateUnknownProblem(Answer):
    """It is not known where a robot of this scene is."""

    code: Literal["robot_state_unknown"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: RobotStateEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


type RobotStatus = Literal["at_rest", "moving", "unknown"] | str
"""Whether a robot moves."""


class Robustness(Answer):
    """Errors that the proof of clearance survives: guaranteed lower bounds, each by itself."""

    joint_error: float
    """Error that every joint may have at once, at most 0.5 [rad or m]."""
    joint_pair: tuple[str, str]
    """The two bodies that allow no more."""
    joint_time: float
    """Time at which these two allow no more [s]."""
    obstacle_displacement: float
    """Distance that all points of all obstacles may have from where the scene has them, at most
    1 [m]."""
    obstacle_pair: tuple[str, str]
    """The two bodies that allow no more."""
    obstacle_time: float
    """Time at which these two allow no more [s]."""


class RoundDocument(Answer):
    """Radius and length of a cylinder or capsule [m]; the axis is z."""

    length: float
    """Length of the cylindrical part [m]."""
    radius: float
    """Radius [m]."""


type SampleRejection = (
    Literal[
        "not_converged", "outside_limits", "collision", "path_constraint", "approach", "duplicate"
    ]
    | str
)
"""Test that an IK sample fails."""


class SamplingReserve(Answer):
    """Clearance that a controller leaves which samples and smooths the motion."""

    approach: float
    """Largest loss of distance between two bodies because of the controller [m]."""
    clearance: float | None
    """Proven lower bound on all distances along the path [m]; null without any pair."""
    deviation: float
    """Largest distance of a joint from the path [rad]."""


class Saving(Answer):
    """Time that the motion would save with one limit relaxed."""

    limit: Limit
    """Name of the limit, as in the intervals."""
    seconds: float
    """Time that is saved [s]."""
    where: str
    """The joint, block, frame or zone whose limit it is."""


class Scene(Answer):
    """A scene: its document and what it holds once loaded."""

    assumed: list[str]
    """Joints whose rate limits are assumed, because no source states them."""
    bodies: list[str]
    """Everything that can collide."""
    created_at: datetime
    """Time at which this revision was made (UTC)."""
    digest: str
    """sha256 of the content, the bytes of all files included."""
    document: SceneDocument
    """Document as it was posted or edited, defaults filled in."""
    frames: list[str]
    """Frames that poses may be given in."""
    groups: list[Group]
    """Groups that can be planned for."""
    id: str
    """Id of the scene."""
    name: str
    """Name for people."""
    num_pairs: int
    """Pairs of bodies that are kept apart."""
    revision: int
    """Revision of its content, from 1."""
    warnings: list[str]
    """Oddities of the scene, for example concave meshes."""
    files: dict[str, Files] = Field(default={}, validate_default=True)
    """Files that its robots and meshes were made from, by name. They are kept: no change of a
    file on the disk changes this scene."""
    unchecked: list[UncheckedPair] = Field(default=[], validate_default=True)
    """Pairs of bodies that no collision check looks at, and why."""


class SceneBrief(Answer):
    """A scene without its content."""

    created_at: datetime
    """Time at which this revision was made (UTC)."""
    digest: str
    """sha256 of the content, the bytes of all files included."""
    id: str
    """Id of the scene."""
    name: str
    """Name for people."""
    revision: int
    """Revision of its content, from 1."""


class SceneDocument(Answer):
    """A scene: robots, obstacles, frames."""

    robots: list[RobotDocument]
    allowed_collisions: list[list[str]] = Field(default=[], validate_default=True)
    """Pairs of bodies that may touch."""
    configurations: dict[str, ConfigurationDocument] = Field(default={}, validate_default=True)
    """Named configurations beside those of the robots."""
    frames: list[FrameDocument] = Field(default=[], validate_default=True)
    groups: dict[str, list[str]] = Field(default={}, validate_default=True)
    """Groups that span groups of robots, `robot` or `robot::group` each, in order."""
    margin: float = 0.0
    """Distance kept from everything but the robot itself [m]."""
    margins: list[MarginDocument] = Field(default=[], validate_default=True)
    """Exceptions from `margin`, by pair."""
    name: str = "scene"
    """Name for people."""
    objects: list[ObjectDocument] = Field(default=[], validate_default=True)
    version: Literal[1] = 1
    """Version of this format."""


class SceneEditEvidence(Answer):
    """Operation that cannot be applied, and what is in its way."""

    allowed: list[list[str]] | None = None
    """Pairs that are allowed to collide."""
    attached: list[str] | None = None
    """Names of what is attached."""
    frame: str | None = None
    """Frame that the object is attached to, or would be."""
    hangs_on: str | None = None
    """Parent of the frame."""
    known: list[str] | None = None
    """Names that exist already."""
    movable: list[str] | None = None
    """Names of what may be moved."""
    name: str | None = None
    """Name that the operation is about."""
    operation: int | None = None
    """Index of the operation, from 0."""
    pair: list[str] | None = None
    """Two bodies that are not allowed to collide."""


class SceneEditImpossibleFailure(Answer):
    """An operation cannot be applied to this scene."""

    code: Literal["scene_edit_impossible"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: SceneEditEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class SceneEditImpossibleProblem(Answer):
    """An operation cannot be applied to this scene."""

    code: Literal["scene_edit_impossible"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: SceneEditEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class SceneFaultEvidence(Answer):
    """Place of a fault in a scene document."""

    bound: int | None = None
    """Largest number that is allowed."""
    faults: list[DocumentFault] | None = None
    """All of them, where there may be several."""
    line: int | None = None
    """Line in the text, from 1; null where it is not known."""
    path: str | None = None
    """Place of the fault, as names and numbers with dots; empty for the root."""
    pointer: str | None = None
    """Place of the fault as a JSON pointer."""


class SceneInvalidFailure(Answer):
    """A scene document has a fault."""

    code: Literal["scene_invalid"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: SceneFaultEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class SceneInvalidProblem(Answer):
    """A scene document has a fault."""

    code: Literal["scene_invalid"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: SceneFaultEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class SceneNotKeptProblem(Answer):
    """What a scene was made from is not there any more."""

    code: Literal["scene_not_kept"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: DigestEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class ScenePage(Answer):
    """Scenes, newest first."""

    items: list[SceneBrief]
    """Scenes on this page."""
    next: str | None
    """Cursor of the next page; null on the last one."""


class ScheduleEvidence(Answer):
    """Why no delays keep several motions apart."""

    encounters: list[Encounter]
    """For two motions, the encounters of whichever waits; for more, the encounters that each
    two must avoid."""
    groups: list[str]
    """Groups of the motions that meet."""
    pair: list[str]
    """The two bodies that meet first."""
    time: float
    """Time of the encounter on the motion that is then under way [s]."""


class ScheduleMotionsResponse(Answer):
    """A proven schedule, or why there is none."""

    failure: Failure | None
    """Reason why there is none: `schedule_not_found` with the pair that meets, `not_certified`
    with the failed checks, `deadline_exceeded`; null if there is one."""
    schedule: MotionSchedule | None
    """The schedule; null if there is none."""


class ScheduleNotFoundFailure(Answer):
    """No delays keep several motions apart."""

    code: Literal["schedule_not_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: ScheduleEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class ScheduleNotFoundProblem(Answer):
    """No delays keep several motions apart."""

    code: Literal["schedule_not_found"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: ScheduleEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class ScopeEvidence(Answer):
    """Scope that a key lacks."""

    needed: ScopeName
    """The scope that the operation needs."""
    scopes: list[ScopeName]
    """Scopes of the key."""


class ScopeMissingProblem(Answer):
    """The key is not good for that."""

    code: Literal["scope_missing"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: ScopeEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


type ScopeName = Literal["read", "plan", "execute", "admin"] | str
"""Scopes of keys."""


class Search(Answer):
    """Options for finding a path."""

    allowed_planning_time: float = 5.0
    """Time for the whole plan, all stages, from when the scene is loaded [s]; stages that it
    cuts are in `result.cut_short`."""
    approach_states: int = 100
    """Least number of waypoints of each straight part; `num_states` is then for the free part."""
    approximate: bool = False
    """Whether a failure has, as evidence `approximate`, the reached configuration that is
    nearest to a goal."""
    attempts: int = 1
    """Number of solutions to look for; the best by `objective` is kept. Of several planners
    each has at least one."""
    bounds: dict[str, list[float]] = Field(default={}, validate_default=True)
    """Lowest and highest value to search in [rad or m], by position name, within the limits."""
    interpolate_time: float | None = None
    """Time for interpolating each solution to `num_states` [s]; null for as long as there is.
    One that takes longer stays as it was (`stages.search.interpolated`)."""
    keep_graph: bool = False
    """Whether the planner's graph is kept for GET /plans/{id}/graph."""
    num_states: int | None = None
    """Least number of waypoints to which the path is interpolated."""
    objective: Literal["length", "weighted_length", "clearance", "duration"] | str = "length"
    """Objective by which solutions are compared, and improved by planners that do so."""
    on_cancel: Literal["discard", "best"] | str = "discard"
    """Scope of a cancel: the plan, or only the search if it has a path by then; that path is
    delivered if it can be timed and proven in 0.9 s."""
    parameters: dict[str, bool | int | float | str] = Field(default={}, validate_default=True)
    """Values of the planner's parameters, by their names in OMPL; of several planners, each
    takes those that it has."""
    planner: str | list[str] = "RRTConnect"
    """Name of the planner in OMPL, see GET /v1/planners; or several names, which take turns.
    `GCS` plans inside regions, and where it cannot the others do, by default RRTConnect."""
    regions: str | None = None
    """Id of the regions that GCS plans in; null for the newest that fit (a plan's `request` has
    the id of those), and where GCS is not among the planners."""
    resolution: float = 0.05
    """Largest joint-space distance between two checked states of an edge [rad or m]."""
    roadmap: Roadmap | None = None
    """Roadmap in which to look for a path first; the planner is used only where it has none.
    Under `path_constraints` it is one that keeps them."""
    setup_time: float | None = None
    """Time for setting up the space and the planner, in each attempt [s]; null for as long as
    it takes. An attempt that took longer gives up."""
    shortcut_time: float | None = None
    """Time for shortening each solution [s]; 0 for none, null for a share of the rest."""
    solve_time: float | None = None
    """Time for the planner, in each attempt [s]; null for as long as there is."""
    spaces: dict[str, Space] = Field(default={}, validate_default=True)
    """Restrictions of joints, by name: `position` keeps the rotation of a planar or floating
    joint as it is at the start; a turning radius [m] makes a car of a planar joint."""
    weights: dict[str, float] = Field(default={}, validate_default=True)
    """Factors of the metric that planners measure by [1], by name of a joint or of one of the
    group's `blocks`; 1 for what is not named."""


class SearchEvidence(Answer):
    """Facts of a search without a path; members that its planner does not tell are absent."""

    approximate: Approximation | None = None
    """The nearest that the search came to a goal, if the request wants it."""
    attempts: int | None = None
    """Number of attempts."""
    budget: float | None = None
    """Time that the setup of the planner may take [s]."""
    goal_distance: float | None = None
    """Distance from the nearest kept configuration to a goal, as a length in joint space [rad
    or m]."""
    graph: dict[str, Any] | None = None
    """Graph that the planner explored, if the request wants it: as of `GET
    /v1/plans/{plan}/graph`."""
    locked: list[str] | None = None
    """Locked joints that no goal has at their start positions."""
    num_edges: int | None = None
    """Number of motions that the planner kept; null where it does not tell."""
    num_given_up: int | None = None
    """Number of attempts whose planner gave up before its time was over."""
    num_goals: int | None = None
    """Number of goal configurations."""
    num_states_checked: int | None = None
    """Number of configurations checked for collision."""
    num_vertices: int | None = None
    """Number of configurations that the planner kept; null where it does not tell."""
    padding: float | None = None
    """Distance that was demanded beyond the margin [m]."""
    planner: str | None = None
    """Name of the planner in OMPL; of several, all names."""
    reason: str | None = None
    """Reason why nothing was left to search for: `start`, `goals` or `setup`."""
    roadmap: dict[str, Any] | None = None
    """Use of a roadmap, if the request has one: as in a search's report."""
    spent: float | None = None
    """Time that the setup of the planner took [s]."""
    status: str | None = None
    """Status of its last attempt, as OMPL names it."""


class SearchReport(Answer):
    """Report of the search stage; lengths are in joint space [rad or m]."""

    attempts: int
    """Number of attempts; 0 where a straight line was free (`direct`) or a roadmap knew a way,
    so that none was needed."""
    length: float
    """And after it [rad or m]."""
    num_motions_checked: int
    """Number of edges checked."""
    num_states_checked: int
    """Configurations checked for collision."""
    num_waypoints: int
    """Number of waypoints of the delivered path."""
    padding: float
    """Distance that was demanded beyond the margin [m]."""
    planner: str
    """Name in OMPL of the planner whose solution was kept; `roadmap` for a roadmap's."""
    raw_length: float
    """Length of the kept solution, before shortcutting [rad or m]."""
    resolution: float
    """Resolution at which edges were checked [rad or m]."""
    solved: int
    """Number of attempts that found an exact solution."""
    attempts_log: list[AttemptReport] = Field(default=[], validate_default=True)
    """One entry per attempt, the first hundred."""
    cost: float = 0.0
    """Cost of the kept solution: a length [rad or m], a duration [s], or, for clearance, length
    over distance."""
    direct: bool = False
    """Whether the straight line was free, so that no search was needed."""
    interpolated: bool = True
    """Whether the path has `num_states` waypoints, if the request has it; false where
    `interpolate_time` was over before."""
    objective: Literal["length", "weighted_length", "clearance", "duration"] | str = "length"
    """Objective by which solutions were compared."""
    regions: RegionsReport | None = None
    """Use of regions, if the planner is GCS."""
    roadmap: RoadmapReport | None = None
    """Use of a roadmap, if the request has one."""
    was_canceled: bool = False
    """Whether a cancel ended the search early."""


class Series(Answer):
    """A motion at equal time steps, as the plots draw it."""

    acceleration_jumps: list[float]
    """Instants at which acceleration jumps, so that jerk is infinite [s]."""
    accelerations: list[list[float]]
    """Accelerations, one row per instant [rad/s^2 or m/s^2]."""
    jerks: list[list[float]]
    """Jerks between the jumps of acceleration, one row per instant [rad/s^3 or m/s^3]."""
    limits: dict[str, Bounds]
    """Scaled limits that the plan was to keep: of `position`, `velocity`, `acceleration`,
    `torque`, and of `jerk` if it is limited."""
    position_names: list[str]
    """A name per position coordinate."""
    positions: list[list[float]]
    """Positions, one row per instant [rad or m]."""
    times: list[float]
    """Instants [s]."""
    tool_speeds: dict[str, list[float]]
    """Speed of the tool frame and of every frame that is limited, by frame [m/s]."""
    torques: list[list[float]]
    """Torques or forces by inverse dynamics, one row per instant [N m or N]."""
    utilisation: dict[str, list[float]]
    """Share of each limit that the coordinate uses which uses most, by the name of its check
    [1]; `torque` whether it is limited or not."""
    velocities: list[list[float]]
    """Velocities, one row per instant [rad/s or m/s]."""
    velocity_names: list[str]
    """A name per velocity coordinate."""
    clearance: list[float | None] | None = None
    """Smallest distance of any two bodies, at most half a metre above the margin [m]; null
    unless `distances` asks for it."""
    closest_pairs: list[tuple[str, str]] | None = None
    """The two bodies of each clearance, or two empty names."""


class ServerRestartedFailure(Answer):
    """The server ended while the job ran, and it may not run again."""

    code: Literal["server_restarted"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: RestartEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class ServerStoppingProblem(Answer):
    """The server ends before it could answer."""

    code: Literal["server_stopping"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: NoEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class ShapeDocument(Answer):
    """Exactly one of the shapes."""

    box: list[float] | None = None
    """Full side lengths x, y, z [m]."""
    capsule: RoundDocument | None = None
    convex: ConvexDocument | None = None
    cylinder: RoundDocument | None = None
    ellipsoid: list[float] | None = None
    """Semi-axes x, y, z [m]."""
    half_space: EmptyDocument | None = None
    """All points with z <= 0 in the object's frame."""
    mesh: MeshDocument | None = None
    sphere: float | None = None
    """Radius [m]."""


class SizeEvidence(Answer):
    """Largest size that a body may have."""

    bound: int | None = None
    """Largest number of bytes that is read."""
    bytes: int | None = None
    """Number of bytes of the body."""


class Source(Answer):
    """Source of a number."""

    source: str
    """Publication that they are from."""
    what: str
    """Numbers that are meant."""


type Space = Literal["full", "position"] | str | Car
"""Part of a joint that is searched, or the curves that a car of it can drive."""


class SpeedZone(Answer):
    """Largest speed of the origin of a frame while it is in a box."""

    box: Box
    """Box in which the speed is limited."""
    frame: str
    """Frame whose origin is limited: any frame of the scene."""
    name: str
    """Name for the certificate's check; no two zones share one."""
    speed: float
    """Largest speed in the box [m/s]."""


class SpliceMotionResponse(Answer):
    """A certified motion from the instant on to the end of the other one, or why there is none."""

    certificate: Certificate | None
    """The proof; null if there is none."""
    failure: Failure | None
    """Reason why there is none: `retiming_failed`, `not_certified` with the failed checks,
    `deadline_exceeded`; null if there is one."""
    interpolation: MotionInterpolation
    """Motion that was taken to be between the samples of the running motion."""
    onto_interpolation: MotionInterpolation
    """Motion that was taken to be between the samples of the other motion."""
    stage: CertifyReport | None
    """Report of the proof; null if there is none."""
    trajectory: Trajectory | None
    """The motion, from the running motion's state at `time`, which is its 0; null if there is
    none."""


type Stage = (
    Literal[
        "load",
        "goals",
        "line",
        "roadmap",
        "search",
        "refine",
        "retime",
        "schedule",
        "certify",
        "explain",
        "samples",
        "regions",
        "execute",
    ]
    | str
)
"""Stages of jobs."""


class StageData(Answer):
    """Stage that begins."""

    at: datetime
    """Time at which it happened (UTC)."""
    detail: str
    """Text for a person, or empty."""
    progress: float
    """Share of the whole job, 0 to 1."""
    stage: Stage
    """The stage that it is in."""
    timings: Timings
    """Seconds of the stages before it."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""


class StageEvent(Answer):
    """The job enters a stage."""

    data: Json[StageData]
    """Stage that begins, and the time that those before it took."""
    event: Literal["stage"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class Stages(Answer):
    """One report per stage."""

    certify: CertifyReport
    """Report of the proof."""
    goals: GoalsReport
    """Report of the goal configurations."""
    refine: RefineReport
    """Report of the optimisation."""
    retime: RetimeReport
    """Report of the timing."""
    search: SearchReport
    """Report of the search."""


class StartConstraintEvidence(Answer):
    """Path constraints that the start violates."""

    violations: list[ConstraintViolation]
    """Constraints that are violated."""


class StartInCollisionFailure(Answer):
    """Bodies overlap at the start."""

    code: Literal["start_in_collision"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: PairsEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class StartInCollisionProblem(Answer):
    """Bodies overlap at the start."""

    code: Literal["start_in_collision"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: PairsEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class StartLimitsEvidence(Answer):
    """Positions of the start outside their limits."""

    joints: list[ViolatedLimit]
    """Coordinates that are outside; violations below 1e-6 are clipped instead."""


class StartMismatchEvidence(Answer):
    """Start of a plan, and positions of the robot."""

    distance: float
    """The largest difference of a coordinate [rad or m]."""
    positions: list[float]
    """Positions of the robot [rad or m]."""
    start: list[float]
    """Start of the plan [rad or m]."""
    bound: float | None = None
    """Largest difference that is allowed [rad or m]."""
    names: list[str] | None = None
    """Names of the coordinates."""


class StartMismatchFailure(Answer):
    """The plan does not start where the robot is."""

    code: Literal["start_mismatch"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: StartMismatchEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class StartMismatchProblem(Answer):
    """The plan does not start where the robot is."""

    code: Literal["start_mismatch"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: StartMismatchEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class StartOutOfLimitsFailure(Answer):
    """The start violates position limits."""

    code: Literal["start_out_of_limits"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: StartLimitsEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class StartOutOfLimitsProblem(Answer):
    """The start violates position limits."""

    code: Literal["start_out_of_limits"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: StartLimitsEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class StartTooNearFailure(Answer):
    """The start is free of collision but violates a margin."""

    code: Literal["start_too_near"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: PairsEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class StartTooNearProblem(Answer):
    """The start is free of collision but violates a margin."""

    code: Literal["start_too_near"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: PairsEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class StartViolatesConstraintFailure(Answer):
    """The start violates path constraints."""

    code: Literal["start_violates_constraint"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: StartConstraintEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class StartViolatesConstraintProblem(Answer):
    """The start violates path constraints."""

    code: Literal["start_violates_constraint"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: StartConstraintEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class StartedEvent(Answer):
    """A worker took the job."""

    data: Json[EventData]
    """Time of the event."""
    event: Literal["started"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class StateEvent(Answer):
    """The live state as it is now; what was between two events is not told."""

    data: Json[LiveState]
    """The live state, whole."""
    event: Literal["state"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class OtherStateSource(Answer):
    """One that a newer server has."""

    type: str


type StateSource = Annotated[
    Annotated[DocumentSource | EditSource | ExecutionSource, Field(discriminator="type")]
    | OtherStateSource,
    Field(union_mode="left_to_right"),
]
"""Source of a robot's positions."""


class StatusData(Answer):
    """Progress of an execution, and the time of it."""

    at: datetime
    """Time at which it happened (UTC)."""
    contacts: list[Contact]
    """Touches so far that the scene does not allow."""
    max_tracking_error: float
    """Largest tracking error so far [rad or m]."""
    positions: list[float]
    """Measured positions [rad or m]."""
    progress: float
    """Share of the path's length that is done, 0 to 1, by place, not by the clock: it shrinks
    on the way back."""
    state: ExecutionState
    """State of the execution."""
    time: float
    """Time along the motion [s]."""
    tracking_error: float
    """Largest distance of a joint from where it should be, now [rad or m]."""
    ahead: float | None = None
    """Time along the motion that it does not pass [s]: it rests before it until an edit of the
    scene clears the way; null for none."""
    behind: float | None = None
    """Time along the motion that it does not pass on the way back [s]; null for none."""
    held: list[HeldStatus] = Field(default=[], validate_default=True)
    """Objects that are held by contact and moved along, where the driver measures them."""
    jitter: Jitter | None = None
    """Delays of the controller's ticks so far; null if not recorded."""
    lateness: float | None = None
    """Longest delay so far with which the controller looked at the clock [s]; load on the
    machine makes the motion fall behind; null if not recorded."""
    motion: int = 0
    """Number of the motion that `time` and `progress` are about: 0 is the one that was asked
    for, the others are in `motions`."""
    path_velocity: float | None = None
    """Seconds of the motion per second of the robot's clock, now; negative is backwards; null
    if not recorded."""
    plan: str | None = None
    """Id of the plan, in the stream of a batch; absent in other streams."""
    torques: list[float] | None = None
    """Measured torques or forces of the motors [N m or N]; null if not known."""
    velocities: list[float] | None = None
    """Measured velocities [rad/s or m/s]; null if not recorded."""


class StatusEvent(Answer):
    """The execution moves, or changes its state; at most twenty times a second."""

    data: Json[StatusData]
    """Progress of the execution."""
    event: Literal["status"]
    """Kind of the event."""
    id: str
    """Id of the event, for `Last-Event-ID`."""


class Steering(Answer):
    """Curves that a car can drive."""

    reverse: bool
    """Whether it drives backwards too."""
    turning_radius: float
    """Radius of its tightest turn, at the base's origin [m]."""


class StopMotionResponse(Answer):
    """A certified motion from the instant on, or why there is none."""

    certificate: Certificate | None
    """The proof; null if there is none."""
    failure: Failure | None
    """Reason why there is none: `retiming_failed`, `not_certified` with the failed checks,
    `deadline_exceeded`; null if there is one."""
    interpolation: MotionInterpolation
    """Motion that was taken to be between the samples of the running motion."""
    stage: CertifyReport | None
    """Report of the proof; null if there is none."""
    trajectory: Trajectory | None
    """The motion, from the running motion's state at `time`, which is its 0; null if there is
    none."""


class StopReport(Answer):
    """Stops along the path within limits, from every instant: guaranteed upper bounds."""

    begin: float
    """Time at which it begins [s]."""
    distance: float
    """Longest way of a joint until it stands [rad or m]."""
    frame: str
    """The tool frame, or empty."""
    joint: str
    """Name of that joint, or block of a planar or floating one."""
    time: float
    """Duration of the longest stop [s]."""
    tool_distance: float | None
    """Longest way of the tool frame until it stands [m]; null without a tool frame."""
    unheld: str = ""
    """With `effort`: `torque` and the joint that cannot hold the robot still somewhere, so that
    no stop ends there; empty if there is none."""
    unheld_at: float | None = None
    """Time along the motion at which that is worst [s]; null for nowhere."""


class StorageEvidence(Answer):
    """Why nothing is written."""

    reason: str
    """Message of the database or the file system."""
    retry_after: float
    """Time after which to ask again [s]."""


class TimeoutEvidence(Answer):
    """Time that a body may take."""

    allowed: float
    """Time that is allowed [s]."""


type Timings = dict[str, float]
"""Seconds by stage [s]."""


class Tolerance(Answer):
    """Tolerance of the tool frame about a target, in the target's own axes."""

    position: list[float] = Field(default=[0.0, 0.0, 0.0], validate_default=True)
    """Half-widths of a box about the target [m]."""
    rotation: list[float] = Field(default=[0.0, 0.0, 0.0], validate_default=True)
    """Largest rotation about each axis [rad]; pi or more leaves the axis free."""


class ToolLimit(Answer):
    """Limits on the speed and acceleration of the origin of a frame."""

    frame: str
    """Any frame of the scene; each is limited once."""
    acceleration: float | None = None
    """Largest acceleration in any direction [m/s^2]; null for any."""
    speed: float | None = None
    """Largest speed [m/s]; null for any."""


class ToolRelaxation(Answer):
    """Changes of a goal of the tool, each of which is sufficient."""

    approach: float | None = None
    """Length of an approach that is free [m]."""
    constraints: list[RelaxedConstraint] | None = None
    """Path constraints each of which would have to give way."""
    cut_short: bool | None = None
    """Whether time ran out, so that smaller changes may be sufficient."""
    obstacles: list[ViolatingPair] | None = None
    """Pairs that would have to be allowed to collide."""
    pose_index: int | None = None
    """Index of the goal's pose that these lengths are for, from 0."""
    position: PartialPose | None = None
    """Another position at the same rotation."""
    positions: list[float] | None = None
    """The group's positions with these pairs [rad or m]."""
    remove: RemovedBody | None = None
    """A body to be removed."""
    retreat: float | None = None
    """Length of a retreat that is free [m]."""
    rotation: PartialPose | None = None
    """Another rotation at the same position."""
    tolerance: LargerTolerance | None = None
    """Larger tolerances."""


class TorqueEvidence(Answer):
    """Joint whose torque was at its limit, and for how long."""

    bound: float
    """Limit of that torque or force [N m or N]."""
    joint: str
    """Full name of the joint."""
    seconds: float
    """Time for which some joint was at its limit [s]."""
    time: float
    """Time along the motion [s]."""
    torque: float
    """Torque or force of its motor [N m or N]."""


class TorqueLimitReachedFailure(Answer):
    """A joint was at its torque limit for too long."""

    code: Literal["torque_limit_reached"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: TorqueEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class TrackingEvidence(Answer):
    """Tracking error of the robot."""

    bound: float | None
    """Largest tracking error that is allowed [rad or m]."""
    error: float | None
    """Tracking error [rad or m]; null where a simulation diverged."""
    time: float
    """Time along the motion [s]."""


class TrackingLostFailure(Answer):
    """The robot left the trajectory."""

    code: Literal["tracking_lost"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: TrackingEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class Trajectory(Answer):
    """A timed motion, sampled; the first and the last instant are included."""

    accelerations: list[list[float]]
    """Accelerations, one row per instant [rad/s^2 or m/s^2]."""
    duration: float
    """Duration of the whole motion [s]."""
    joint_names: list[str]
    """A name per position coordinate, in row order."""
    positions: list[list[float]]
    """One row per instant [rad or m]."""
    times: list[float]
    """Instants of the samples [s]."""
    velocities: list[list[float]]
    """Velocities, one row per instant [rad/s or m/s]."""
    velocity_names: list[str]
    """A name per velocity coordinate; as `joint_names`, but for floating joints."""
    interpolations: list[Interpolation] = Field(default=[], validate_default=True)
    """Proofs of the samples, by what receivers make of them; the certificate beside them is
    that of the exact motion. Empty for older plans."""
    polynomial: Polynomial | None = None
    """The exact motion, if the request has it added."""


class TransitionEvidence(Answer):
    """Event that a state does not allow."""

    event: RefusedEvent
    """Event that was requested."""
    legal: list[RefusedEvent]
    """Events that are allowed in that state."""
    state: RefusingState
    """State at present."""


class Translation(Answer):
    """A translation without a rotation."""

    vector: list[float]
    """Translation [m]."""
    frame: str = "world"
    """Frame in whose axes the vector is, as they stand at the start."""


class UnauthorizedProblem(Answer):
    """The request has no key that is valid."""

    code: Literal["unauthorized"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: NoEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class UncheckedPair(Answer):
    """Two bodies that no collision check looks at."""

    bodies: tuple[str, str]
    """Full names of the bodies, sorted."""
    evidence: str
    """Evidence for the reason, in words."""
    reason: Literal["allowed", "held", "welded", "welded_to_world", "adjacent"] | str
    """allowed: by the scene or the robot's description; held: one is attached and may touch the
    other; welded: neither can move relative to the other; welded_to_world: both stand in the
    world; adjacent: a joint joins them, and their shapes touch about it or can never touch."""


class UnknownJobProblem(Answer):
    """There is no such job."""

    code: Literal["unknown_job"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: JobIdEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class UnknownNameFailure(Answer):
    """A name does not exist."""

    code: Literal["unknown_name"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: NameEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class UnknownNameProblem(Answer):
    """A name does not exist."""

    code: Literal["unknown_name"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: NameEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class UnknownResourceEvidence(Answer):
    """Resource that does not exist; empty where the address leads nowhere."""

    id: str | None = None
    """Id that was given."""
    kind: ResourceKind | None = None
    """Kind of what was looked for."""
    known: list[str] | None = None
    """Names of models that exist."""
    name: str | None = None
    """Name of the model that was asked for."""
    nearest: list[str] | None = None
    """Known names that were perhaps meant, the nearest first."""


class UnreadableBodyProblem(Answer):
    """The body is not what its content type says."""

    code: Literal["unreadable_body"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: UnreadableEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class UnreadableEvidence(Answer):
    """Why a body cannot be read."""

    line: int | None = None
    """Line with the fault, from 1."""
    position: int | None = None
    """Index of the first wrong character, from 0."""
    reason: str | None = None
    """What is wrong with it."""


class UnsupportedMediaTypeProblem(Answer):
    """The body has a content type that is not read here."""

    code: Literal["unsupported_media_type"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: MediaTypeEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class UrRtdeDriver(Answer):
    """An arm of Universal Robots, by RTDE."""

    host: str
    """Name of a controller in the server's settings (`WAYPROOF_UR_HOSTS`)."""
    type: Literal["ur_rtde"]
    """Protocol of its controller."""


class Verdict(Answer):
    """Verdict on one configuration."""

    collisions: list[Pair]
    """All pairs that touch or are nearer than the margin, deepest first."""
    distance: float | None
    """Smallest signed distance [m]; null if there is no pair to look at."""
    limit_violations: list[LimitViolation]
    """Joints outside their limits."""
    nearest: Pair | None
    """The pair that is nearest; null if there is none."""
    valid: bool
    """Whether it is within limits, and nothing is nearer than the margin."""


type Versions = dict[str, str]
"""Versions of everything that the numbers depend on, by name."""


class ViolatedLimit(Answer):
    """A position outside its limits."""

    joint: str
    """Name of the coordinate."""
    lower: float | None
    """Its lower bound, null for none [rad or m]."""
    position: float
    """Its value [rad or m]."""
    upper: float | None
    """Its upper bound, null for none [rad or m]."""
    violation: float
    """Distance to the limit that is violated [rad or m]."""


class ViolatingPair(Answer):
    """Two bodies that overlap or violate their margin."""

    bodies: tuple[str, str]
    """Full names of both bodies."""
    depth: float
    """Distance that is missing to the margin [m]."""
    distance: float
    """Distance between them, negative where they overlap [m]."""
    margin: float
    """Margin that is demanded between them [m]."""
    points: list[list[float]]
    """Nearest points of both bodies in world [m]; the deepest ones where they overlap."""


class VisibleBody(Answer):
    """A body that is drawn."""

    name: str
    """Full name, which is also that of its frame."""
    shapes: list[VisibleShape]
    """Its visual shapes; its collision shapes if it has none."""
    pose: Pose | None = None
    """Pose in world; null for what moves with a robot: `POST …/fk` tells where its frame is."""


class VisibleShape(Answer):
    """A shape that is drawn: exactly one of the first seven members is not null."""

    color: list[float]
    """Red, green, blue, opacity, 0 to 1; a mesh with materials has its own colours."""
    pose: Pose
    """Pose on its body."""
    box: list[float] | None = None
    """Full side lengths x, y, z [m]."""
    capsule: RoundDocument | None = None
    """Capsule along z."""
    cylinder: RoundDocument | None = None
    """Along z."""
    ellipsoid: list[float] | None = None
    """Semi-axes x, y, z [m]."""
    half_space: EmptyDocument | None = None
    """All points with z <= 0."""
    mesh: MeshName | None = None
    """Mesh of triangles."""
    sphere: float | None = None
    """Radius [m]."""


class Wait(Answer):
    """Who waits for whom, and why."""

    delay: float
    """Time that it waits, from the beginning of the schedule [s]."""
    for_group: str
    """Group of the motion that it waits for: begun earlier, it would meet this one."""
    group: str
    """Group of the motion that waits."""
    pair: list[str]
    """The two bodies that would be nearer than their margin."""
    time: float
    """Time on the schedule at which they would, if it began a little earlier [s]."""


class Webhook(Answer):
    """An address that is told what happens to jobs."""

    created_at: datetime
    """Time of the registration (UTC)."""
    disabled_at: datetime | None
    """Time since which nothing is sent, because it failed for days or said 410 (UTC); null if
    it is enabled."""
    events: list[WebhookEvent]
    """Events that are told."""
    failing_since: datetime | None
    """Time since which it has taken nothing that was sent (UTC); null if it takes them."""
    id: str
    """Id of the webhook."""
    reason: str
    """Reason of the last failure since a success, or empty."""
    url: str
    """Address to which messages are posted."""


type WebhookEvent = (
    Literal[
        "plan.started",
        "plan.requeued",
        "plan.finished",
        "regions.started",
        "regions.requeued",
        "regions.finished",
        "execution.started",
        "execution.finished",
    ]
    | str
)
"""Event that a webhook can be told."""


class WebhookPage(Answer):
    """Webhooks, newest first."""

    items: list[Webhook]
    """Webhooks on this page."""
    next: str | None
    """Cursor of the next page; null on the last one."""


class WorkerCrashedEvidence(Answer):
    """How the worker's process died."""

    attempts: int
    """Number of times that the job was started."""
    exit_code: int | None
    """Exit code; negative where a signal ended the worker, null if unknown."""
    during: str | None = None
    """The stage that it told last."""
    reason: str | None = None
    """Last message of the worker, or empty."""
    signal: str | None = None
    """Name of the signal."""


class WorkerCrashedFailure(Answer):
    """The worker process died under the job, every time."""

    code: Literal["worker_crashed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: WorkerCrashedEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class WorkerCrashedProblem(Answer):
    """The worker process died under the job, every time."""

    code: Literal["worker_crashed"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: WorkerCrashedEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class WorkerSilentEvidence(Answer):
    """Time for which the worker's process said nothing."""

    silence: float
    """Seconds."""
    attempts: int | None = None
    """Number of times that the job was started."""
    during: str | None = None
    """The stage that it told last."""


class WorkerUnresponsiveFailure(Answer):
    """The worker process said nothing for too long, and was ended."""

    code: Literal["worker_unresponsive"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What went wrong, for a person."""
    evidence: WorkerSilentEvidence
    """Facts behind it [SI units, radians]."""
    stage: AnyStage
    """The stage that gave up, or in which the time ran out or the cancel came: a name in
    `timings`, for example `goals`; `worker` if it is not known; or empty."""
    timings: Timings = Field(default={}, validate_default=True)
    """Seconds per stage, of those that ended and of the one that failed; empty where nothing
    was timed."""


class WorkerUnresponsiveProblem(Answer):
    """The worker process said nothing for too long, and was ended."""

    code: Literal["worker_unresponsive"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: WorkerSilentEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""


class WrongJointCountProblem(Answer):
    """A list of joint values that does not fit the group."""

    code: Literal["wrong_joint_count"]
    """Stable machine-readable name of the kind."""
    detail: str
    """What is wrong with this request, for a person."""
    evidence: CountEvidence
    """Facts behind it [SI units, radians]."""
    status: int
    """The HTTP status, again."""
    title: str
    """The kind of problem, for a person."""
    type: str
    """`urn:wayproof:problem:` and the code."""
    errors: list[ProblemError] = Field(default=[], validate_default=True)
    """What is wrong in the body or in parameters, at most 20; absent where no place of them is."""
