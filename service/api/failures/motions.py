"""Evidence of failures from the search to the execution of a motion."""

from typing import NotRequired, TypedDict

from pydantic import with_config

from service.api.document.known_values import (
    CheckName,
    CheckUnit,
    RefusedEvent,
    RefusingState,
    RetimingMethod,
    VerdictCheck,
)
from service.api.failures.parts import OPEN, FunnelEvidence


@with_config(OPEN)
class Approximation(TypedDict):
    """The nearest that a search came to a goal."""

    positions: list[float]
    """Configuration of the search that is nearest to a goal [rad or m]"""
    path: list[list[float]]
    """Path to that configuration, one row per waypoint [rad or m]"""
    goal_distance: float
    """Distance from that configuration to the goal, as a length in joint space [rad or m]"""
    goal: list[float]
    """The goal configuration that it is nearest to [rad or m]"""


@with_config(OPEN)
class SearchEvidence(TypedDict):
    """Facts of a search without a path; members that its planner does not tell are absent."""

    planner: NotRequired[str]
    """Name of the planner in OMPL; of several, all names"""
    reason: NotRequired[str]
    """Reason why nothing was left to search for: `start`, `goals` or `setup`"""
    locked: NotRequired[list[str]]
    """Locked joints that no goal has at their start positions"""
    padding: NotRequired[float]
    """Distance that was demanded beyond the margin [m]"""
    attempts: NotRequired[int]
    """Number of attempts"""
    num_goals: NotRequired[int]
    """Number of goal configurations"""
    num_states_checked: NotRequired[int]
    """Number of configurations checked for collision"""
    status: NotRequired[str]
    """Status of its last attempt, as OMPL names it"""
    num_vertices: NotRequired[int | None]
    """Number of configurations that the planner kept; null where it does not tell"""
    num_edges: NotRequired[int | None]
    """Number of motions that the planner kept; null where it does not tell"""
    goal_distance: NotRequired[float | None]
    """Distance from the nearest kept configuration to a goal, as a length in joint space [rad
    or m]"""
    num_given_up: NotRequired[int]
    """Number of attempts whose planner gave up before its time was over"""
    budget: NotRequired[float]
    """Time that the setup of the planner may take [s]"""
    spent: NotRequired[float]
    """Time that the setup of the planner took [s]"""
    approximate: NotRequired[Approximation | None]
    """The nearest that the search came to a goal, if the request wants it"""
    graph: NotRequired[dict[str, object]]
    """Graph that the planner explored, if the request wants it: as of `GET /v1/plans/{plan}/graph`
    """
    roadmap: NotRequired[dict[str, object]]
    """Use of a roadmap, if the request has one: as in a search's report"""


@with_config(OPEN)
class DeadlineEvidence(TypedDict):
    """Work that was done when the time was over; of a search, as in `SearchEvidence`."""

    allowed: NotRequired[float]
    """Time that was allowed [s]"""
    grace: NotRequired[float]
    """Time beyond it after which a worker that had not ended was ended [s]"""
    during: NotRequired[str]
    """Work during which the time ran out"""
    waited: NotRequired[float]
    """Time that the question waited for a worker before [s]"""
    funnel: NotRequired[FunnelEvidence]
    """In the stage `goals`, number of samples that passed each test until then"""
    max_trials: NotRequired[int]
    """In the stage `goals`, number of samples to be tried"""
    cut_short: NotRequired[bool]
    """In the stage `goals`, that the funnel is not complete"""
    planner: NotRequired[str]
    """In the stage `search`, name of the planner in OMPL; of several, all names"""
    attempts: NotRequired[int]
    """In the stage `search`, number of attempts"""
    num_goals: NotRequired[int]
    """In the stage `search`, number of goal configurations"""
    num_states_checked: NotRequired[int]
    """In the stage `search`, number of configurations checked for collision"""
    num_vertices: NotRequired[int | None]
    """In the stage `search`, number of configurations that the planner kept; null where it does
    not tell
    """
    num_edges: NotRequired[int | None]
    """In the stage `search`, number of motions that the planner kept; null where it does not tell
    """
    goal_distance: NotRequired[float | None]
    """In the stage `search`, distance from the nearest configuration to a goal, as a length in
    joint space [rad or m]
    """
    approximate: NotRequired[Approximation | None]
    """In the stage `search`, the nearest configuration to a goal, if the request wants it"""
    graph: NotRequired[dict[str, object]]
    """In the stage `search`, graph that the planner explored, if the request wants it"""


@with_config(OPEN)
class CancelEvidence(TypedDict):
    """Place of a cancel."""

    during: NotRequired[str]
    """Work during which the cancel came"""
    time: NotRequired[float]
    """Time along the motion of an execution [s]"""
    reason: NotRequired[str]
    """Reason why the server ended it; absent if a client did"""


@with_config(OPEN)
class RetimingEvidence(TypedDict):
    """Why the path has no timing."""

    method: NotRequired[RetimingMethod]
    """Method of timing"""
    duration: NotRequired[float]
    """Duration that was requested [s]"""
    least: NotRequired[float]
    """Least duration that the limits allow [s]"""
    limit: NotRequired[str]
    """Name of the limit that is too low"""
    stuck: NotRequired[list[str]]
    """Joints that have to move, and may not because of that limit"""
    where: NotRequired[str]
    """Joint whose limit on torque is too low"""
    torque: NotRequired[float]
    """Torque or force that gravity alone needs there [N m or N]"""
    bound: NotRequired[float]
    """Torque or force that the joint may use [N m or N]"""
    at: NotRequired[float]
    """Share of the path at which that is [0 to 1]"""
    joints: NotRequired[list[str]]
    """Joints of types that the method does not move"""
    result: NotRequired[str]
    """Result that the method reported"""
    missed: NotRequired[float]
    """Distance by which the method missed the end of the path [rad or m]"""
    num_cells: NotRequired[int]
    """Number of pieces that the path was cut into"""
    num_grid_points: NotRequired[int]
    """Number of points at which the path was sampled"""


@with_config(OPEN)
class FailedCheck(TypedDict):
    """A check of the certificate that failed."""

    name: CheckName
    """Name of the check"""
    value: float | None
    """Worst value of the check, in `unit`; null where it is not finite"""
    bound: float | None
    """Bound of the check, in `unit`; null where it is not finite"""
    unit: NotRequired[CheckUnit]
    """Unit of value and bound; `1` for a number without one"""
    where: str
    """The joint, frame or bodies, or empty"""
    time: NotRequired[float]
    """Time on the motion at which the value is worst [s]"""
    positions: NotRequired[list[float]]
    """The group's positions at that time [rad or m]"""


@with_config(OPEN)
class Encounter(TypedDict):
    """Two motions that would meet."""

    pair: list[str]
    """The two bodies"""
    distance: float
    """Distance of both bodies then, negative where they overlap [m]"""
    times: dict[str, float]
    """Time of the encounter on each group's own motion [s]"""
    waiting: NotRequired[str]
    """Group that does not avoid the encounter, however long it waits"""


@with_config(OPEN)
class ScheduleEvidence(TypedDict):
    """Why no delays keep several motions apart."""

    groups: list[str]
    """Groups of the motions that meet"""
    pair: list[str]
    """The two bodies that meet first"""
    time: float
    """Time of the encounter on the motion that is then under way [s]"""
    encounters: list[Encounter]
    """For two motions, the encounters of whichever waits; for more, the encounters that each two
    must avoid
    """


@with_config(OPEN)
class CertificateEvidence(TypedDict):
    """Why no motion passed the certifier; of executions, why the plan's does not by now."""

    checks: list[FailedCheck]
    """Failed checks of the last motion, the worst first"""
    refused: NotRequired[list[str]]
    """Each motion that was refused, and why"""
    check: NotRequired[VerdictCheck]
    """Name of the first failed check; executions only"""
    pair: NotRequired[list[str]]
    """The two bodies that come too near, if that is the check; executions only"""
    time: NotRequired[float]
    """Time on the motion of the first failed check [s]; executions only"""
    value: NotRequired[float | None]
    """Worst value of that check; executions only"""
    bound: NotRequired[float | None]
    """Bound of that check; executions only"""
    execution: NotRequired[str]
    """Id of the execution whose motion is in the way, if the check is `beside`"""
    other_time: NotRequired[float]
    """Time on the motion of that execution [s], if the check is `beside`"""


@with_config(OPEN)
class TransitionEvidence(TypedDict):
    """Event that a state does not allow."""

    state: RefusingState
    """State at present"""
    event: RefusedEvent
    """Event that was requested"""
    legal: list[RefusedEvent]
    """Events that are allowed in that state"""


@with_config(OPEN)
class TrackingEvidence(TypedDict):
    """Tracking error of the robot."""

    error: float | None
    """Tracking error [rad or m]; null where a simulation diverged"""
    bound: float | None
    """Largest tracking error that is allowed [rad or m]"""
    time: float
    """Time along the motion [s]"""


@with_config(OPEN)
class ContactEvidence(TypedDict):
    """Bodies that touched."""

    pair: list[str]
    """Full names of both bodies"""
    depth: NotRequired[float]
    """Depth by which they overlap [m]"""
    force: NotRequired[float | None]
    """Force between them [N]; null where it is not known"""
    time: float
    """Time along the motion [s]"""
    execution: NotRequired[str]
    """Id of the execution that moves the other robot, if one does"""


@with_config(OPEN)
class TorqueEvidence(TypedDict):
    """Joint whose torque was at its limit, and for how long."""

    joint: str
    """Full name of the joint"""
    torque: float
    """Torque or force of its motor [N m or N]"""
    bound: float
    """Limit of that torque or force [N m or N]"""
    seconds: float
    """Time for which some joint was at its limit [s]"""
    time: float
    """Time along the motion [s]"""


@with_config(OPEN)
class PathBlockedEvidence(TypedDict):
    """Part of a motion that does not hold in the scene as it was edited."""

    check: VerdictCheck
    """Name of the failed check of the certificate"""
    pair: list[str]
    """Full names of both bodies, if it is about two"""
    time: float
    """Time along the motion [s]"""
    fraction: float
    """Share of the path's length that lies before that place [0 to 1]"""
    revision: int
    """Revision of the scene that has the conflict"""
    execution: NotRequired[str | None]
    """Id of the execution whose motion is in the way, if the check is `beside`; else null"""


@with_config(OPEN)
class DriverLostEvidence(TypedDict):
    """Driver that was lost, and what is known of its robot."""

    driver: str
    """Name of the driver"""
    reason: str
    """Reason of the loss"""
    rests: bool
    """Whether the robot is known to rest where it was last measured"""
