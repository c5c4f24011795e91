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
    """Distance of two poses: sqrt((translation * t)^2 + (rotation * angle)^2)."""

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
    """Options of the search for goal configurations."""

    max_configurations: Annotated[int, Strict(), Field(ge=1, le=10_000), WHOLE] = Field(
        default=100,
        description="Number of configurations at most, the nearest to the start of all that "
        "are found; as many are "
        "looked for, but 100 at least, and until 40 in a row are known already",
    )
    max_trials: Annotated[int, Strict(), Field(ge=1, le=100_000), WHOLE] = Field(
        default=300, description="Largest number of seeds of the solver, over all poses"
    )
    joint_weights: dict[JointName, NonNegative] = Field(
        default={},
        max_length=256,
        description="Factor on each joint's part of the distance from the start, by full name "
        "(`robot::joint`); 1 for joints that are not named [1]",
    )
    pose_metric: PoseMetric = Field(
        default_factory=PoseMetric,
        description="Metric of the nearest pose to one that no configuration reaches",
    )
    allowed_time: Annotated[Real, Field(gt=0, le=3600)] | None = Field(
        default=None,
        description="Time for finding them, or for saying why there is none [s]; null for "
        "as long as there is",
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
    """Two bodies that were the deepest collision of rejected configurations."""

    bodies: tuple[str, str] = Field(description="Full names of the bodies")
    count: int = Field(description="Number of rejected configurations")
    min_depth: float = Field(description="Smallest depth among them [m]")
    max_depth: float = Field(description="Largest depth among them [m]")


class ApproachFailures(ResponseModel):
    """Configurations whose approach or retreat one cause stopped."""

    leg: LineLeg = Field(description="Line that was stopped, the approach or the retreat")
    reason: LineStopReason = Field(description="Reason why they stopped")
    where: str = Field(description="Pair of bodies or joint that stopped them, or empty")
    count: int = Field(description="Number of configurations")
    max_fraction: float = Field(
        description="Largest share of the line that was free, from the goal outwards, 0 to 1 [1]"
    )


class Funnel(ResponseModel):
    """How many IK samples survived what; every number is at most the one before it."""

    tried: int = Field(description="Number of seeds given to the solver")
    converged: int = Field(description="Number of those that reached the target within tolerance")
    within_limits: int = Field(description="Number of those that kept the joint limits")
    collision_free: int = Field(description="Number of those that touch nothing")
    approach_ok: int = Field(
        default=0,
        description="Number of those with a free, continuous approach and retreat; all "
        "without a request for them",
    )
    distinct: int = Field(description="Number of those that differ from all others")
    rejected_by: list[CollidingPair] = Field(
        description="Pairs that the colliding ones hit, of the first few that were measured"
    )
    blocked_by: list[ApproachFailures] = Field(
        default=[], description="Reasons that stopped approaches and retreats, most frequent first"
    )
    violating: int = Field(
        default=0,
        description="Number of goal configurations, whole turns included, that were "
        "dropped because they or their lines violate a path constraint",
    )
    breaking: int = Field(
        default=0, description="Number of collision-free samples that violate a path constraint"
    )


class Rejection(ResponseModel):
    """Why some samples are no goal configurations."""

    reason: SampleRejection = Field(description="Test that they failed")
    count: int = Field(
        description="Number of samples; with `distinct` the counts add up to `tried`"
    )
    share: float = Field(description="Share of `tried`, 0 to 1")
    bodies: tuple[str, str] | None = Field(
        description="For `collision`, the deepest pair; null for samples that time was "
        "too short to measure"
    )
    min_depth: float | None = Field(description="Smallest depth among them [m]")
    max_depth: float | None = Field(description="Largest depth among them [m]")


class IkFunnel(Funnel):
    """Number of samples that pass each test, with the reason of every rejected sample."""

    rejected: list[Rejection] = Field(
        default=[], description="Reasons why the others are no solutions"
    )
    summary: str = Field(default="", description="The same as a sentence")
