"""What became of the samples of inverse kinematics."""

from typing import Literal

from pydantic import Field

from service.api.models import ResponseModel


class PairTally(ResponseModel):
    """How often two bodies were the deepest collision of a rejected configuration."""

    bodies: tuple[str, str] = Field(description="Full names")
    count: int = Field(description="Rejected configurations")
    min_depth: float = Field(description="Smallest depth among them [m]")
    max_depth: float = Field(description="Largest depth among them [m]")


class LegTally(ResponseModel):
    """How often one thing stopped the approach or retreat of a configuration."""

    leg: str = Field(description="`approach` or `retreat`")
    reason: str = Field(description="`limit`, `singularity`, `collision` or `unreachable`")
    where: str = Field(description="The pair of bodies or the joint, or empty")
    count: int = Field(description="Configurations")
    max_fraction: float = Field(
        description="The most of the line that was free, seen from the goal [1]"
    )


class Funnel(ResponseModel):
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
    rejected_by: list[PairTally] = Field(
        description="Which pairs the colliding ones hit, of the first few that were measured"
    )
    blocked_by: list[LegTally] = Field(
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


class Rejection(ResponseModel):
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


class IkFunnel(Funnel):
    """The same, with the reason of every rejected sample."""

    rejected: list[Rejection] = Field(default=[], description="Why the others are no solutions")
    summary: str = Field(default="", description="The same as a sentence")
