"""Asking where frames are, and which configurations bring them somewhere."""

from typing import Annotated

from pydantic import ConfigDict, Field, Strict

from service.schemas.goal import PoseGoalWire
from service.schemas.numbers import WHOLE, NonNegative, Positions, Real
from service.schemas.plan import IkWire
from service.schemas.pose import PoseWire
from service.schemas.problem import Failure
from service.schemas.report import FunnelWire
from service.schemas.wire import Answer, Name, Wire


class FkRequest(Wire):
    """Ask where frames are in given configurations."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"group": "arm", "configurations": [[0, -1.57, 1.57, -1.57, -1.57, 0]]}]
        }
    )

    group: Name = Field(description="`robot` or `robot::group`")
    configurations: Annotated[list[Positions], Field(min_length=1, max_length=10_000)] = Field(
        description="The group's positions, one row each [rad or m]"
    )
    frames: Annotated[list[Name], Field(min_length=1, max_length=1000)] | None = Field(
        default=None, description="Any frames of the scene; null for the group's tool frames"
    )


class FkResponse(Answer):
    """Poses per configuration, in order."""

    results: list[dict[str, PoseWire]] = Field(
        description="Pose in world per frame, in the order of the configurations"
    )


class IkRequest(Wire):
    """Ask for all configurations that reach a pose."""

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

    group: Name = Field(description="`robot` or `robot::group`")
    goal: PoseGoalWire = Field(description="Where the tool frame shall be")
    start: Positions | None = Field(
        default=None,
        description="What `nearest` is measured from [rad or m]; null for the scene's state",
    )
    ik: IkWire = Field(default_factory=IkWire, description="How hard to look")
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    allowed_time: Annotated[Real, Field(gt=0, le=60)] = Field(
        default=5.0, description="Stop after this long, with what was found [s]"
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="Of all randomness"
    )


class IkSolutionWire(Answer):
    """A goal configuration."""

    positions: list[float] = Field(description="The group's positions [rad or m]")
    pose_index: int = Field(description="Which of the goal's poses it reaches, from 0")


class IkResponse(Answer):
    """All distinct goal configurations, nearest to the start first, or why there are none."""

    configurations: list[IkSolutionWire] = Field(description="Free, within limits, distinct")
    funnel: FunnelWire | None = Field(description="How many samples survived what")
    failure: Failure | None = Field(
        description="Why there is none: `goal_unreachable` with the nearest pose, "
        "`goal_in_collision` with the pairs, `approach_blocked`; null if there is one"
    )
