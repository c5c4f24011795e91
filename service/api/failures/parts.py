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
    """Position x, y, z [m]"""
    quaternion: list[float]
    """Rotation w, x, y, z"""


@with_config(OPEN)
class ViolatingPair(TypedDict):
    """Two bodies that overlap or violate their margin."""

    bodies: Bodies
    """Full names of both bodies"""
    distance: float
    """Distance between them, negative where they overlap [m]"""
    margin: float
    """Margin that is demanded between them [m]"""
    depth: float
    """Distance that is missing to the margin [m]"""
    points: list[list[float]]
    """Nearest points of both bodies in world [m]; the deepest ones where they overlap"""


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
    """Distance to the limit that is violated [rad or m]"""


@with_config(OPEN)
class ConstraintViolation(TypedDict):
    """A path constraint that is violated."""

    constraint: str
    """Place of the constraint in the request and its kind"""
    value: float | None
    """Value of the constraint, in `unit`"""
    bound: float | None
    """Bound of the constraint, in `unit`"""
    unit: str
    """Unit of value and bound; `1` for a number without one"""
    joint: NotRequired[str]
    """Worst joint, for constraints on joints"""


@with_config(OPEN)
class RejectedPair(TypedDict):
    """Number of configurations that were rejected with one pair as the deepest collision."""

    bodies: Bodies
    """Full names of both bodies"""
    count: int
    """Number of configurations"""
    min_depth: float
    """Least depth of the collision among them [m]"""
    max_depth: float
    """Largest depth of the collision among them [m]"""


@with_config(OPEN)
class BlockedMoves(TypedDict):
    """Number of approaches or retreats that stopped for one reason."""

    leg: LineLeg
    """`approach` or `retreat`"""
    reason: LineStopReason
    """Reason why they stopped"""
    where: str
    """Pair of bodies or joint that stopped them, or empty"""
    count: int
    """Number of configurations"""
    max_fraction: float
    """The largest part of the line that is free, from the goal outwards [0 to 1]"""


@with_config(OPEN)
class RejectedSamples(TypedDict):
    """Why some samples are no goal configurations."""

    reason: SampleRejection
    """Test that they failed"""
    count: int
    """Number of samples"""
    share: float
    """Share of all samples that were tried [0 to 1]"""
    bodies: Bodies | None
    """The deepest pair of collisions; null where it was not measured"""
    min_depth: float | None
    """The least depth among them [m]"""
    max_depth: float | None
    """The largest depth among them [m]"""


@with_config(OPEN)
class FunnelEvidence(TypedDict):
    """Number of samples of inverse kinematics that pass each test."""

    tried: int
    """Number of seeds given to the solver"""
    converged: int
    """Number of them that reached the target"""
    within_limits: int
    """Number of the converged ones within the joint limits"""
    collision_free: int
    """Number of those that are free of collisions"""
    breaking: NotRequired[int]
    """Number of the free ones that violate a path constraint"""
    violating: NotRequired[int]
    """Goal configurations dropped for path constraints, whole turns included"""
    approach_ok: NotRequired[int]
    """Number of the free ones that keep path constraints and have free approach and retreat"""
    distinct: int
    """Number of those that differ from all others"""
    rejected_by: list[RejectedPair]
    """Collisions by pair, the most frequent first"""
    blocked_by: NotRequired[list[BlockedMoves]]
    """Reasons that stopped approaches and retreats, the most frequent first"""
    rejected: NotRequired[list[RejectedSamples]]
    """Reasons why the others are not among the distinct ones; the counts add up to those tried"""
    summary: NotRequired[str]
    """Summary of the funnel as a sentence"""
