"""Objects that grippers hold by contact, as they are measured while something moves."""

from typing import Self

from pydantic import Field

from planning.domain.geometry.pose import Pose
from planning.domain.scene.held_pose import HeldPose
from service.api.models import ResponseModel


class MeasuredPose(ResponseModel):
    """A measured rigid transform."""

    position: list[float] = Field(description="x, y, z [m]")
    quaternion: list[float] = Field(description="[w, x, y, z], of length 1")

    @classmethod
    def of(cls, pose: Pose) -> Self:
        """Return a pose as clients see it."""
        return cls(position=pose.position.tolist(), quaternion=pose.quaternion.tolist())


class HeldStatus(ResponseModel):
    """An object that a gripper holds by contact, as measured."""

    object: str = Field(description="Name of the object")
    frame: str = Field(description="Frame of the robot that it is attached to")
    pose: MeasuredPose = Field(description="Pose of the object in that frame")
    world_pose: MeasuredPose = Field(description="Pose of the object in the world")
    slip: float = Field(
        description="Largest distance of a corner of its bounding box from where it was proven to "
        "be held [m]"
    )
    bound: float = Field(description="Largest `slip` that does not count as a loss [m]")
    is_lost: bool = Field(description="Whether it has left its place in the gripper")

    @classmethod
    def from_domain(cls, held: HeldPose) -> Self:
        """Return it as clients see it."""
        return cls(
            object=held.name,
            frame=held.frame,
            pose=MeasuredPose.of(held.in_frame),
            world_pose=MeasuredPose.of(held.in_world),
            slip=held.slip,
            bound=held.bound,
            is_lost=held.is_lost,
        )
