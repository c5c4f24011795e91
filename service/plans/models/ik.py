"""How a plan, or a question, looks for goal configurations."""

from typing import Annotated

from pydantic import Field, Strict

from planning.domain.request import options as domain
from service.api.models import RequestModel
from service.api.names import JointName
from service.api.numbers import WHOLE, NonNegative, Real


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
        description="At most so many, the nearest to the start of all that are found; as many are "
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
    time_limit: Annotated[Real, Field(gt=0, le=3600)] | None = Field(
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
            time_limit=self.time_limit,
        )
