"""Asking where frames are, and which configurations bring them somewhere."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, Strict

from planning.domain.goals.configuration_quality import ConfigurationQuality
from service.api.failures.failure import Failure
from service.api.models import (
    GROUP,
    WHOLE,
    FrameName,
    GroupName,
    GroupPositions,
    NonNegative,
    Pose,
    Real,
    RequestModel,
    ResponseModel,
)
from service.plans.models.constraints import Constraint
from service.plans.models.goals import RelativeGoal
from service.plans.models.ik import Ik, IkFunnel
from service.plans.models.pose_goals import PoseGoal, RegionGoal

if TYPE_CHECKING:
    import numpy as np


class FkRequest(RequestModel):
    """Ask where frames are in given configurations."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"group": "arm", "configurations": [[0, -1.57, 1.57, -1.57, -1.57, 0]]}]
        }
    )

    group: GroupName = Field(description=GROUP)
    configurations: Annotated[list[GroupPositions], Field(min_length=1, max_length=10_000)] = Field(
        description="The group's positions, one row each [rad or m]"
    )
    frames: Annotated[list[FrameName], Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="Any frames of the scene; null for the group's tool frames"
    )


class FkResponse(ResponseModel):
    """Poses per configuration, in order."""

    results: list[dict[str, Pose]] = Field(
        description="Pose in world per frame, in the order of the configurations"
    )


class IkRequest(RequestModel):
    """Ask for all configurations that reach a pose, a region or a displacement."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "group": "arm",
                    "goal": {
                        "type": "pose",
                        "poses": [{"position": [0.4, 0.2, 0.3], "quaternion": [0, 1, 0, 0]}],
                    },
                    "seed": 1,
                }
            ]
        }
    )

    group: GroupName = Field(description=GROUP)
    goal: PoseGoal | RegionGoal | RelativeGoal = Field(
        discriminator="type", description="Goal of the tool frame"
    )
    start: GroupPositions | None = Field(
        default=None,
        description="Configuration that distances are measured from [rad or m]; null for "
        "the scene's state",
    )
    path_constraints: Annotated[list[Constraint], Field(max_length=64)] = Field(
        default=[],
        description="Constraints that solutions shall keep; joints are locked where "
        "`start` has them",
    )
    ik: Ik = Field(default_factory=Ik, description="Options of the search")
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    allowed_time: Annotated[Real, Field(gt=0, le=60)] = Field(
        default=5.0, description="Time after which to stop, with what was found [s]"
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="Seed of all randomness"
    )


class Branch(ResponseModel):
    """Sides to which a six-joint arm bends; one changes only at its singularity, where it is 0."""

    model_config = ConfigDict(from_attributes=True)

    shoulder: Literal[-1, 0, 1] = Field(description="Side of the first axis on which the wrist is")
    elbow: Literal[-1, 0, 1] = Field(description="Side to which the elbow bends")
    wrist: Literal[-1, 0, 1] = Field(description="Side to which the wrist bends")


class IkSolution(ResponseModel):
    """A goal configuration, and how good it is."""

    positions: list[float] = Field(description="The group's positions [rad or m]")
    pose_index: int = Field(description="Index of the goal's pose that it reaches, from 0")
    manipulability: float = Field(
        description="Yoshikawa's sqrt(det(J J^T)) of the tool; it mixes metres and radians, so it "
        "compares configurations of one arm"
    )
    clearance: float | None = Field(
        description="Smallest signed distance of any two bodies [m]; null if nothing can collide"
    )
    pair: tuple[str, str] | None = Field(description="Full names of the two bodies of `clearance`")
    limit_margin: float | None = Field(
        description="Smallest distance to a position limit as a share of its range, 0 to 0.5; null "
        "if nothing is limited"
    )
    distance: float = Field(
        description="Distance from the start, by `ik.joint_weights` [rad or m]; the "
        "answers are sorted by it"
    )
    branch: Branch | None = Field(
        description="Branch of a six-joint arm with a spherical wrist or one like "
        "Universal Robots'; null for others"
    )

    @classmethod
    def from_domain(
        cls, q: "np.ndarray[Any, Any]", pose_index: int, quality: ConfigurationQuality
    ) -> Self:
        """Return a goal configuration."""
        return cls(
            positions=q.tolist(),
            pose_index=pose_index,
            manipulability=quality.manipulability,
            clearance=quality.clearance,
            pair=quality.pair,
            limit_margin=quality.limit_margin,
            distance=quality.distance,
            branch=None if quality.branch is None else Branch.model_validate(quality.branch),
        )


class IkResponse(ResponseModel):
    """All distinct goal configurations, nearest to the start first, or why there are none."""

    configurations: list[IkSolution] = Field(
        description="Distinct goal configurations that are free and within limits"
    )
    funnel: IkFunnel | None = Field(description="Number of samples that passed each test")
    failure: Failure | None = Field(
        description="Reason why there is none, null if there is one: `goal_unreachable`, "
        "`goal_in_collision`, `goal_too_near`, `approach_blocked`, "
        "`goal_violates_constraint` or `deadline_exceeded`. The evidence has "
        "the `nearest` feasible pose, the `relaxation` that is sufficient, "
        "what blocks the approaches and what is violated; at a deadline, the "
        "funnel so far"
    )
