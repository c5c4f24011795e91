"""Parts that the evidence of several errors has.

Evidence is a JSON object as the error wrote it; these types say what is in it and stand in the
OpenAPI document. Members may be added, so unknown ones are allowed everywhere.
"""

from typing import NotRequired, TypedDict

from pydantic import ConfigDict, with_config

from service.api.models import LineLeg, LineStopReason, SampleRejection

OPEN = ConfigDict(extra="allow", use_attribute_docstrings=True)

# Of two bodies.
type Bodies = tuple[str, str]


@with_config(OPEN)
class NoEvidence(TypedDict):
    """Nothing: the detail says all."""


@with_config(OPEN)
class PlainPose(TypedDict):
    """A pose in world."""

    position: list[float]
    """x, y, z [m]"""
    quaternion: list[float]
    """w, x, y, z"""


@with_config(OPEN)
class ViolatingPair(TypedDict):
    """Two bodies that overlap or violate their margin."""

    bodies: Bodies
    """Full names"""
    distance: float
    """Between them, negative where they overlap [m]"""
    margin: float
    """That is demanded between them [m]"""
    depth: float
    """What is missing to the margin [m]"""
    points: list[list[float]]
    """The nearest points of both in world, or the deepest ones [m]"""


@with_config(OPEN)
class ViolatedLimit(TypedDict):
    """A position outside its limits."""

    joint: str
    """Name of the coordinate"""
    position: float
    """Its value [rad or m]"""
    lower: float | None
    """Its lower bound, null for none [rad or m]"""
    upper: float | None
    """Its upper bound, null for none [rad or m]"""
    violation: float
    """By how much it is outside [rad or m]"""


@with_config(OPEN)
class ConstraintViolation(TypedDict):
    """A path constraint that is violated."""

    constraint: str
    """Its place in the request and its kind"""
    value: float | None
    """What it is, in `unit`"""
    bound: float | None
    """What it may be, in `unit`"""
    unit: str
    """Of both; `1` for a number without one"""
    joint: NotRequired[str]
    """Of constraints on joints, the worst one"""


@with_config(OPEN)
class RejectedPair(TypedDict):
    """How many configurations were rejected with one pair as the deepest collision."""

    bodies: Bodies
    """Full names"""
    count: int
    """Configurations"""
    min_depth: float
    """The least depth among them [m]"""
    max_depth: float
    """The largest depth among them [m]"""


@with_config(OPEN)
class BlockedMoves(TypedDict):
    """How many approaches or retreats stopped for one reason."""

    leg: LineLeg
    """Which"""
    reason: LineStopReason
    """Why"""
    where: str
    """The pair of bodies or the joint, or empty"""
    count: int
    """Configurations"""
    max_fraction: float
    """The largest part of the line that is free, from the goal outwards [0 to 1]"""


@with_config(OPEN)
class RejectedSamples(TypedDict):
    """Why some samples are no goal configurations."""

    reason: SampleRejection
    """Which test they failed"""
    count: int
    """Samples"""
    share: float
    """Of the samples tried [0 to 1]"""
    bodies: Bodies | None
    """The deepest pair of collisions; null where it was not measured"""
    min_depth: float | None
    """The least depth among them [m]"""
    max_depth: float | None
    """The largest depth among them [m]"""


@with_config(OPEN)
class FunnelEvidence(TypedDict):
    """How many samples of inverse kinematics pass each test."""

    tried: int
    """Seeds given to the solver"""
    converged: int
    """Those that reached the target"""
    within_limits: int
    """Of these, those within the joint limits"""
    collision_free: int
    """Of these, those that are free"""
    breaking: NotRequired[int]
    """Of the free ones, those that violate a path constraint"""
    violating: NotRequired[int]
    """Goal configurations dropped for path constraints, whole turns included"""
    approach_ok: NotRequired[int]
    """Of the free ones that keep path constraints, those with free approach and retreat"""
    distinct: int
    """Of these, those that differ from all others"""
    rejected_by: list[RejectedPair]
    """Collisions by pair, the most frequent first"""
    blocked_by: NotRequired[list[BlockedMoves]]
    """What stopped approaches and retreats, the most frequent first"""
    rejected: NotRequired[list[RejectedSamples]]
    """Why the others are not among the distinct ones; the counts add up to those tried"""
    summary: NotRequired[str]
    """The same as a sentence"""
