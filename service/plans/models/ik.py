"""How a plan or a query looks for goal configurations, and what became of its samples."""

from typing import Annotated

from pydantic import Field, Strict

from planning.domain.request import options as domain
from service.api.models import (
    WHOLE,
    JointName,
    LineLeg,
    LineStopReason,
    NonNegative,
    Real,
    RequestModel,
    ResponseModel,
    SampleRejection,
)


class PoseMetric(RequestModel):
    """How far apart two poses are: sqrt((translation * t)^2 + (rotation * angle)^2)."""

    translation: Annotated[Real, Field(ge=1e-3, le=1e3)] = Field(
        default=1.0, description="Weight of a metre [1/m]"
    )
    rotation: Annotated[Real, Field(ge=1e-3, le=1e3)] = Field(
        default=0.1,
        description="Weight of a radian [1/rad]; by default one weighs as much as 0.1 m",
    )

    def to_domain(self) -> domain.PoseMetric:
        """Return the domain's metric."""
        return domain.PoseMetric(self.translation, self.rotation)


class Ik(RequestModel):
    """How hard to look for goal configurations, and which of them are near."""

    max_configurations: Annotated[int, Strict(), Field(ge=1, le=10_000), WHOLE] = Field(
        default=100,
        description="Number of configurations at most, the nearest to the start of all that "
        "are found; as many are "
        "looked for, but 100 at least, and until 40 in a row are known already",
    )
    max_trials: Annotated[int, Strict(), Field(ge=1, le=100_000), WHOLE] = Field(
        default=300, description="Stop after this many seeds of the solver, over all poses"
    )
    joint_weights: dict[JointName, NonNegative] = Field(
        default={},
        max_length=256,
        description="Factor on each joint's part of the distance from the start, by full name "
        "(`robot::joint`); 1 for joints that are not named [1]",
    )
    pose_metric: PoseMetric = Field(
        default_factory=PoseMetric,
        description="Which pose is the nearest to one that no configuration reaches",
    )
    allowed_time: Annotated[Real, Field(gt=0, le=3600)] | None = Field(
        default=None,
        description="For finding them, or saying why there is none [s]; null for as long as there "
        "is",
    )

    def to_domain(self) -> domain.IkOptions:
        """Return the domain's IK options."""
        return domain.IkOptions(
            max_configurations=self.max_configurations,
            max_trials=self.max_trials,
            joint_weights=dict(self.joint_weights),
            pose_metric=self.pose_metric.to_domain(),
            allowed_time=self.allowed_time,
        )


class CollidingPair(ResponseModel):
    """How often two bodies were the deepest collision of a rejected configuration."""

    bodies: tuple[str, str] = Field(description="Full names")
    count: int = Field(description="Rejected configurations")
    min_depth: float = Field(description="Smallest depth among them [m]")
    max_depth: float = Field(description="Largest depth among them [m]")


class ApproachFailures(ResponseModel):
    """How often one thing stopped the approach or retreat of a configuration."""

    leg: LineLeg = Field(description="Which of both")
    reason: LineStopReason = Field(description="Why it stopped")
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
        description="Have a free, continuous approach and retreat; all without a request for them",
    )
    distinct: int = Field(description="Differ from all others")
    rejected_by: list[CollidingPair] = Field(
        description="Which pairs the colliding ones hit, of the first few that were measured"
    )
    blocked_by: list[ApproachFailures] = Field(
        default=[], description="What stopped approaches and retreats, most frequent first"
    )
    violating: int = Field(
        default=0,
        description="Goal configurations, whole turns included, that were dropped because they or "
        "their lines violate a path constraint",
    )
    breaking: int = Field(
        default=0, description="Collision-free samples that violate a path constraint"
    )


class Rejection(ResponseModel):
    """Why some samples are no goal configurations."""

    reason: SampleRejection = Field(description="What is wrong with them")
    count: int = Field(description="How many; with `distinct` the counts add up to `tried`")
    share: float = Field(description="Share of `tried`, 0 to 1")
    bodies: tuple[str, str] | None = Field(
        description="For `collision`, what they hit deepest; null for those that time was short for"
    )
    min_depth: float | None = Field(description="Smallest depth among them [m]")
    max_depth: float | None = Field(description="Largest depth among them [m]")


class IkFunnel(Funnel):
    """The same, with the reason of every rejected sample."""

    rejected: list[Rejection] = Field(default=[], description="Why the others are no solutions")
    summary: str = Field(default="", description="The same as a sentence")
