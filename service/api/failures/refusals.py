"""Evidence of requests that the service does not carry out."""

from typing import Any, NotRequired, TypedDict

from pydantic import with_config

from service.api.document.known_values import MotionlessState, ResourceKind, ScopeName
from service.api.failures.parts import OPEN


@with_config(OPEN)
class UnreadableEvidence(TypedDict):
    """Why a body cannot be read."""

    reason: NotRequired[str]
    """What is wrong with it"""
    position: NotRequired[int | None]
    """Index of the first wrong character, from 0"""
    line: NotRequired[int]
    """Line with the fault, from 1"""


@with_config(OPEN)
class HostEvidence(TypedDict):
    """Whom a request was for."""

    host: str
    """Host in the request"""


@with_config(OPEN)
class OriginEvidence(TypedDict):
    """Origin of the page that asked."""

    origin: str
    """Origin in the request"""


@with_config(OPEN)
class TimeoutEvidence(TypedDict):
    """Time that a body may take."""

    allowed: float
    """Time that is allowed [s]"""


@with_config(OPEN)
class UnknownResourceEvidence(TypedDict):
    """Resource that does not exist; empty where the address leads nowhere."""

    kind: NotRequired[ResourceKind]
    """Kind of what was looked for"""
    id: NotRequired[str]
    """Id that was given"""
    name: NotRequired[str]
    """Name of the model that was asked for"""
    known: NotRequired[list[str]]
    """Names of models that exist"""
    nearest: NotRequired[list[str]]
    """Known names that were perhaps meant, the nearest first"""


@with_config(OPEN)
class AddressEvidence(TypedDict):
    """Address that a webhook may not lead to."""

    host: str
    """Host in the URL"""
    pointer: str
    """JSON pointer to the URL in the body"""


@with_config(OPEN)
class ReadinessEvidence(TypedDict):
    """Why the server is not ready."""

    faults: NotRequired[dict[str, str]]
    """Reason why no worker is ready, by kind of work"""
    retry_after: NotRequired[float]
    """Time after which to ask again [s]"""


@with_config(OPEN)
class NoTrajectoryEvidence(TypedDict):
    """State of a plan that has no motion."""

    id: NotRequired[str]
    """Id of the plan"""
    state: NotRequired[MotionlessState]
    """State of the plan"""
    failure: NotRequired[dict[str, Any] | None]
    """Reason why it has no motion, if it ended without one"""


@with_config(OPEN)
class NoRegionsEvidence(TypedDict):
    """Regions that were looked for."""

    scene: NotRequired[str]
    """Id of the scene"""
    digest: str
    """Digest of the scene's content"""
    group: str
    """Group that the regions are for"""
    margin: float
    """Least margin that the regions keep [m]"""
    there: list[dict[str, Any]]
    """Regions that there are, and why they do not fit"""


@with_config(OPEN)
class StartMismatchEvidence(TypedDict):
    """Start of a plan, and positions of the robot."""

    start: list[float]
    """Start of the plan [rad or m]"""
    positions: list[float]
    """Positions of the robot [rad or m]"""
    distance: float
    """The largest difference of a coordinate [rad or m]"""
    bound: NotRequired[float]
    """Largest difference that is allowed [rad or m]"""
    names: NotRequired[list[str]]
    """Names of the coordinates"""


@with_config(OPEN)
class RobotStateEvidence(TypedDict):
    """Robots that have to be looked at."""

    robots: list[str]
    """Names of the robots"""


@with_config(OPEN)
class BusyEvidence(TypedDict):
    """Execution that moves a robot, or waits for it."""

    execution: str
    """Id of the execution"""
    group: str
    """Group that it moves"""


@with_config(OPEN)
class RevisionEvidence(TypedDict):
    """Which revision the scene is at."""

    revision: int
    """Revision that the request names"""
    latest: int
    """Latest revision"""


@with_config(OPEN)
class EntityTagEvidence(TypedDict):
    """Revision that the scene is at."""

    revision: int
    """Latest revision"""
    etag: str
    """`ETag` of the latest revision"""
    asked: str
    """Tag in `If-Match`"""


@with_config(OPEN)
class DigestEvidence(TypedDict):
    """Scene that is not kept."""

    digest: str
    """Digest of the content of the scene"""


@with_config(OPEN)
class SizeEvidence(TypedDict):
    """Largest size that a body may have."""

    bound: NotRequired[int]
    """Largest number of bytes that is read"""
    bytes: NotRequired[int]
    """Number of bytes of the body"""


@with_config(OPEN)
class MediaTypeEvidence(TypedDict):
    """Content types that are read instead."""

    got: NotRequired[str]
    """The content type that came"""
    known: NotRequired[list[str]]
    """Content types that are read"""


@with_config(OPEN)
class ScopeEvidence(TypedDict):
    """Scope that a key lacks."""

    needed: ScopeName
    """The scope that the operation needs"""
    scopes: list[ScopeName]
    """Scopes of the key"""


@with_config(OPEN)
class RateEvidence(TypedDict):
    """Number of requests that a caller may make."""

    limit: str
    """Limit in the server's settings, such as `600/minute`"""
    retry_after: float
    """Time after which to ask again [s]"""


@with_config(OPEN)
class KeyNameEvidence(TypedDict):
    """Which key there is already."""

    name: str
    """Of the key"""


@with_config(OPEN)
class ListenEvidence(TypedDict):
    """Where a server would listen."""

    host: str
    """As its settings have it"""
