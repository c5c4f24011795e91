"""Evidence of failures from the search to the execution of a motion."""

from typing import NotRequired, TypedDict

from pydantic import with_config

from service.api.failures.parts import OPEN, FunnelEvidence


@with_config(OPEN)
class Approximation(TypedDict):
    """The nearest that a search came to a goal."""

    positions: list[float]
    """The configuration [rad or m]"""
    path: list[list[float]]
    """To it, a row for each configuration [rad or m]"""
    goal_distance: float
    """From a goal, as a length in joint space [rad or m]"""
    goal: list[float]
    """That goal [rad or m]"""


@with_config(OPEN)
class SearchEvidence(TypedDict):
    """What a search without a path did; members that its planner does not tell are absent."""

    planner: NotRequired[str]
    """OMPL's name; of several, all"""
    reason: NotRequired[str]
    """`start`, `goals` or `setup` where nothing could be searched for because of these"""
    locked: NotRequired[list[str]]
    """Locked joints that no goal has at their start positions"""
    padding: NotRequired[float]
    """Distance that was demanded beyond the margin [m]"""
    attempts: NotRequired[int]
    """How many were made"""
    num_goals: NotRequired[int]
    """Goal configurations"""
    num_states_checked: NotRequired[int]
    """Configurations checked for collision"""
    status: NotRequired[str]
    """OMPL's word for how its last attempt ended"""
    num_vertices: NotRequired[int | None]
    """Configurations that the planner kept; null where it does not tell"""
    num_edges: NotRequired[int | None]
    """Motions that the planner kept; null where it does not tell"""
    goal_distance: NotRequired[float | None]
    """From the nearest of them to a goal, as a length in joint space [rad or m]"""
    num_given_up: NotRequired[int]
    """Attempts whose planner gave up before its time was over"""
    budget: NotRequired[float]
    """What setting the planner up may take [s]"""
    spent: NotRequired[float]
    """What it took [s]"""
    approximate: NotRequired[Approximation | None]
    """The nearest to a goal, if the request wants it"""
    graph: NotRequired[dict[str, object]]
    """What the planner explored, if the request wants it: as of `GET /v1/plans/{plan}/graph`"""
    roadmap: NotRequired[dict[str, object]]
    """What a roadmap did, if the request has one: as in a search's report"""


@with_config(OPEN)
class DeadlineEvidence(TypedDict):
    """What had been done when the time was over; of a search, as in `SearchEvidence`."""

    allowed: NotRequired[float]
    """Seconds that it might take"""
    during: NotRequired[str]
    """The work at which it ended"""
    waited: NotRequired[float]
    """Seconds for which a question waited for a worker before"""
    funnel: NotRequired[FunnelEvidence]
    """In the stage `goals`, how many samples passed each test until then"""
    max_trials: NotRequired[int]
    """In the stage `goals`, how many samples were to be tried"""
    cut_short: NotRequired[bool]
    """In the stage `goals`, that the funnel is not complete"""
    planner: NotRequired[str]
    """In the stage `search`, OMPL's name; of several, all"""
    attempts: NotRequired[int]
    """In the stage `search`, how many were made"""
    num_goals: NotRequired[int]
    """In the stage `search`, goal configurations"""
    num_states_checked: NotRequired[int]
    """In the stage `search`, configurations checked for collision"""
    goal_distance: NotRequired[float | None]
    """In the stage `search`, from the nearest to a goal, as a length in joint space [rad or m]"""
    approximate: NotRequired[Approximation | None]
    """In the stage `search`, the nearest to a goal, if the request wants it"""
    graph: NotRequired[dict[str, object]]
    """In the stage `search`, what the planner explored, if the request wants it"""


@with_config(OPEN)
class CancelEvidence(TypedDict):
    """Where a cancel came."""

    during: NotRequired[str]
    """The work at which it ended"""
    time: NotRequired[float]
    """Of an execution, along the motion [s]"""
    reason: NotRequired[str]
    """Where the server ended it, not a client: why"""


@with_config(OPEN)
class RetimingEvidence(TypedDict):
    """Why the path has no timing."""

    method: NotRequired[str]
    """Of timing"""
    duration: NotRequired[float]
    """That was requested [s]"""
    least: NotRequired[float]
    """That the limits allow [s]"""
    limit: NotRequired[str]
    """Which one is too low"""
    stuck: NotRequired[list[str]]
    """Joints that move and may not, because of it"""
    where: NotRequired[str]
    """Of a limit on torques: the joint"""
    torque: NotRequired[float]
    """That gravity alone needs [N m or N]"""
    bound: NotRequired[float]
    """That it may use [N m or N]"""
    at: NotRequired[float]
    """The share of the way where that is [0 to 1]"""
    joints: NotRequired[list[str]]
    """Of types that the method does not move"""
    result: NotRequired[str]
    """What the method said"""
    missed: NotRequired[float]
    """By how much it missed the end of the path [rad or m]"""
    num_cells: NotRequired[int]
    """Pieces that the path was cut into"""
    num_grid_points: NotRequired[int]
    """Points that the path was sampled at"""


@with_config(OPEN)
class FailedCheck(TypedDict):
    """A check of the certificate that failed."""

    name: str
    """Of the check"""
    value: float | None
    """Its worst value, in the unit of the check; null where it is not finite"""
    bound: float | None
    """What it may be; null where it is not finite"""
    unit: NotRequired[str]
    """Of both; `1` for a number without one"""
    where: str
    """The joint, frame or bodies, or empty"""
    time: NotRequired[float]
    """On the motion [s]"""
    positions: NotRequired[list[float]]
    """The group's positions at that time [rad or m]"""


@with_config(OPEN)
class Encounter(TypedDict):
    """Two motions that would meet."""

    pair: list[str]
    """The two bodies"""
    distance: float
    """Between them then, negative where they overlap [m]"""
    times: dict[str, float]
    """When, by the time of each group's own motion [s]"""
    waiting: NotRequired[str]
    """The group that does not avoid it, however long it waits"""


@with_config(OPEN)
class ScheduleEvidence(TypedDict):
    """Why no delays keep several motions apart."""

    groups: list[str]
    """Groups of the motions that meet"""
    pair: list[str]
    """The two bodies that meet first"""
    time: float
    """When, by the time of the motion that is then under way [s]"""
    encounters: list[Encounter]
    """Of two motions what either meets that waits; of more, what each two must avoid"""


@with_config(OPEN)
class GraspEvidence(TypedDict):
    """Why fingers do not hold an object."""

    object: str
    """Its name"""
    width: float
    """How far the fingers are apart where they have closed [m]"""
    distances: list[float | None]
    """Between the object and each finger then [m]; null beyond 5 cm"""
    bound: float
    """What they may be [m]"""


@with_config(OPEN)
class CertificateEvidence(TypedDict):
    """Why no motion passed the certifier; of executions, why the plan's does not by now."""

    checks: list[FailedCheck]
    """Of the last motion, the worst first"""
    refused: NotRequired[list[str]]
    """Each motion that was refused, and why"""
    check: NotRequired[str]
    """Of executions, the first of the checks"""
    pair: NotRequired[list[str]]
    """Of executions, the two bodies that come too near, if that is the check"""
    time: NotRequired[float]
    """Of executions, when on the motion [s]"""
    value: NotRequired[float | None]
    """Of executions, the worst value of that check"""
    bound: NotRequired[float | None]
    """Of executions, what it may be"""
    execution: NotRequired[str]
    """Of the check `beside`, id of the execution whose motion is in the way"""
    other_time: NotRequired[float]
    """Of the check `beside`, when on the motion of that one [s]"""


@with_config(OPEN)
class TransitionEvidence(TypedDict):
    """What a state does not allow."""

    state: str
    """The present one"""
    event: str
    """What was asked for"""
    legal: list[str]
    """What is allowed in that state"""


@with_config(OPEN)
class TrackingEvidence(TypedDict):
    """How far the robot is off."""

    error: float | None
    """The tracking error [rad or m]; null where a simulation diverged"""
    bound: float | None
    """What it may be [rad or m]"""
    time: float
    """On the motion [s]"""


@with_config(OPEN)
class ContactEvidence(TypedDict):
    """What touched what."""

    pair: list[str]
    """Full names of both bodies"""
    depth: NotRequired[float]
    """By which they overlap [m]"""
    force: NotRequired[float | None]
    """Force between them [N]; null where it is not known"""
    time: float
    """On the motion [s]"""
    execution: NotRequired[str]
    """Id of the execution that moves the other robot, if one does"""


@with_config(OPEN)
class TorqueEvidence(TypedDict):
    """Which joint's torque was at its limit, and for how long."""

    joint: str
    """Full name"""
    torque: float
    """Of the motor [N m or N]"""
    bound: float
    """What it may be [N m or N]"""
    seconds: float
    """How long some joint was at its limit [s]"""
    time: float
    """On the motion [s]"""


@with_config(OPEN)
class PathBlockedEvidence(TypedDict):
    """What of a motion does not hold in the scene as it was edited."""

    check: str
    """Of the certificate"""
    pair: list[str]
    """Full names of both bodies, if it is about two"""
    time: float
    """On the motion [s]"""
    fraction: float
    """Share of the path's length that is done there"""
    revision: int
    """Of the scene"""
    execution: NotRequired[str | None]
    """Of the check `beside`, id of the execution whose motion is in the way; null for others"""


@with_config(OPEN)
class DriverLostEvidence(TypedDict):
    """Which driver was lost, and what is known of its robot."""

    driver: str
    """Its name"""
    reason: str
    """What happened"""
    rests: bool
    """Whether the robot is known to rest where it was last measured"""
