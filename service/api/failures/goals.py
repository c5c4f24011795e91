"""Evidence of failures in the stage `goals`: at the start, and at the goal."""

from typing import NotRequired, TypedDict

from pydantic import with_config

from service.api.failures.diagnosis import LineStopEvidence, Nearest, Relaxation
from service.api.failures.parts import (
    OPEN,
    ConstraintViolation,
    FunnelEvidence,
    ViolatedLimit,
    ViolatingPair,
)


@with_config(OPEN)
class PairsEvidence(TypedDict):
    """Pairs of bodies at the start."""

    pairs: list[ViolatingPair]
    """Pairs that overlap or violate their margin"""


@with_config(OPEN)
class StartLimitsEvidence(TypedDict):
    """Positions of the start outside their limits."""

    joints: list[ViolatedLimit]
    """Coordinates that are outside; violations below 1e-6 are clipped instead"""


@with_config(OPEN)
class StartConstraintEvidence(TypedDict):
    """Path constraints that the start violates."""

    violations: list[ConstraintViolation]
    """Constraints that are violated"""


@with_config(OPEN)
class GoalLimitsEvidence(TypedDict):
    """Positions of the goal's configurations outside their limits."""

    joints: list[ViolatedLimit]
    """Coordinates that are outside"""
    nearest: NotRequired[Nearest]
    """The nearest feasible configuration, null if none was found"""
    relaxation: NotRequired[Relaxation]
    """Changes that would be sufficient"""


@with_config(OPEN)
class GoalEvidence(TypedDict):
    """Why no goal configuration is feasible, and what would have to change."""

    funnel: FunnelEvidence
    """Number of samples that passed each test"""
    pairs: NotRequired[list[ViolatingPair]]
    """Pairs of the least infeasible of the given configurations"""
    nearest: NotRequired[Nearest]
    """The nearest feasible pose or configuration, null if none was found"""
    relaxation: NotRequired[Relaxation]
    """Changes that would be sufficient"""


@with_config(OPEN)
class CountedViolation(TypedDict):
    """Number of goal configurations that violate one path constraint."""

    constraint: str
    """Its place in the request and its kind"""
    count: int
    """Goal configurations"""
    least: ConstraintViolation
    """The least violation among them"""


@with_config(OPEN)
class GoalConstraintEvidence(TypedDict):
    """Path constraints that all goal configurations violate."""

    violations: list[CountedViolation]
    """Violations by constraint, the most frequent first"""
    nearest: NotRequired[Nearest]
    """The nearest feasible pose or configuration, null if none was found"""
    relaxation: NotRequired[Relaxation]
    """Constraint that would have to give way, and how far"""


@with_config(OPEN)
class LineEvidence(TypedDict):
    """Place at which a straight line stops."""

    line: int
    """Index of the goal's line, from 0"""
    fraction: float
    """Share of the line that is free [0 to 1]"""
    length: float
    """Length of the line [m]"""
    stopped_by: LineStopEvidence
    """Place and reason of the stop"""
