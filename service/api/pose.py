"""Pose in JSON."""

import math
from typing import Self

from pydantic import ConfigDict, Field, model_validator

from planning.domain.geometry import pose as domain
from planning.domain.goals.goal import PoseTarget
from service.api.models import RequestModel
from service.api.names import FrameName
from service.api.numbers import Quadruple, Triple


def require_one_rotation(quaternion: list[float] | None, rpy: list[float] | None) -> None:
    """Go on only if a rotation is given once, or not at all, and is one.

    Raises:
        ValueError: It is not.
    """
    if quaternion is not None and rpy is not None:
        message = "give `quaternion` or `rpy`, not both"
        raise ValueError(message)
    if quaternion is not None and not math.hypot(*quaternion) > 1e-9:
        message = "quaternion [w, x, y, z] must not be zero"
        raise ValueError(message)


class Pose(RequestModel):
    """A rigid transform in a frame; `quaternion` or `rpy`, or neither for no rotation."""

    model_config = ConfigDict(
        title="Pose",
        json_schema_extra={
            "examples": [
                {"position": [0.4, 0.2, 0.3], "quaternion": [0, 1, 0, 0], "frame": "world"}
            ]
        },
    )

    position: Triple = Field(description="x, y, z in `frame` [m]")
    quaternion: Quadruple | None = Field(
        default=None, description="Rotation as [w, x, y, z]; normalised when read, never zero"
    )
    rpy: Triple | None = Field(
        default=None, description="Rotation as roll, pitch, yaw about fixed x, y, z [rad]"
    )
    frame: FrameName = Field(
        default="world", description="The frame that the pose is given in: any frame of the scene"
    )

    @model_validator(mode="after")
    def _one_rotation(self) -> Self:
        require_one_rotation(self.quaternion, self.rpy)
        return self

    @classmethod
    def from_domain(cls, pose: domain.Pose) -> Self:
        """Return the model of a pose in world, which is not validated again."""
        position, quaternion = pose.position.tolist(), pose.quaternion.tolist()
        return cls.model_construct(position=position, quaternion=quaternion)

    def to_domain(self) -> domain.Pose:
        """Return the transform, without the frame that it is given in."""
        return domain.Pose.from_parts(self.position, self.quaternion, self.rpy)

    def to_target(self) -> PoseTarget:
        """Return the transform with the frame that it is given in."""
        return PoseTarget(self.to_domain(), self.frame)
