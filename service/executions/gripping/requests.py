"""Requests to open and to close grippers."""

from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from planning import AttachObject, DetachObject, GripperCommand
from planning.domain.scene.grip import Grip
from service.api.fingerprint import ADDED
from service.api.models import (
    GROUP,
    BodyName,
    FrameName,
    GroupName,
    Identifier,
    Name,
    NonNegative,
    Real,
    RequestModel,
)

_EXAMPLES: list[Any] = [
    {"scene": "scn_3f0c5b1e9a7d4c62", "group": "arm::gripper", "grasp": {"object": "can"}},
    {"scene": "scn_3f0c5b1e9a7d4c62", "group": "arm::gripper", "width": 0.05, "release": "can"},
]


class Grasp(RequestModel):
    """Close on an object, and hold it from then on."""

    object: BodyName = Field(
        description="Name of the object; it must be `movable`, and between the fingers"
    )
    frame: FrameName | None = Field(
        default=None,
        description="Frame that the object follows from then on; null for the first tool "
        "frame of the gripper",
    )
    touch: Annotated[list[BodyName], Field(max_length=1000)] | None = Field(
        default=None,
        description="Bodies that the object may touch then; null for those of `attach`: "
        "the fingers, and bodies that move rigidly with the frame",
    )
    by: Annotated[Literal["weld", "contact"], ADDED] = Field(
        default="weld",
        description="`weld`: it follows the frame as if welded to it; `contact`: a simulated "
        "robot holds it by friction alone, between fingers that press with `force`, and may lose "
        "it (`grasp_lost`). Plans and proofs take it to be welded where it is held. `contact` "
        "needs the `simulated` driver, and an object with a `mass`",
    )
    friction: Annotated[Annotated[Real, Field(gt=0, le=10)], ADDED] = Field(
        default=0.5,
        description="Of `contact`: coefficient of Coulomb friction a of the object; that of a "
        "contact is 2ab / (a + b), where the b of the finger is 1 unless its description says "
        "otherwise",
    )
    slip: Annotated[Annotated[Real, Field(ge=0.0001, le=1)], ADDED] = Field(
        default=0.005,
        description="Of `contact`: largest distance by which the object may move in the gripper "
        "before it counts as lost [m]. Proofs know nothing of it: bodies may come that much "
        "nearer to it",
    )
    gap: Annotated[Real, Field(ge=0.0001, le=0.01)] = Field(
        default=0.0002,
        description="Distance that the nearest finger keeps from the object [m]. The "
        "grasp is a weld, not a contact, and a simulated robot that touches "
        "something is stopped",
    )
    reach: Annotated[Real, Field(ge=0.0001, le=0.1)] = Field(
        default=0.002,
        description="Largest distance of any finger from the object [m]; beyond it the "
        "object is not held (`grasp_missed`)",
    )


class GripperRequest(RequestModel):
    """Open or close a gripper, from where its fingers are."""

    model_config = ConfigDict(json_schema_extra={"examples": _EXAMPLES})

    scene: Identifier = Field(description="Id of a scene; it moves in its latest revision")
    group: GroupName = Field(description=f"A group that is a gripper: {GROUP}")
    width: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None,
        description="Distance that the fingers shall have [m], from 0 to "
        "`gripper.max_width` of the group; null to close on the object of "
        "`grasp`",
    )
    grasp: Grasp | None = Field(
        default=None,
        description="Close on an object; once the fingers rest it is attached as `attach` does it, "
        "where it was measured to be",
    )
    release: Name | None = Field(
        default=None,
        description="Name of the object to let go of: it is detached once the fingers "
        "have opened to `width`",
    )
    force: Annotated[Real, Field(gt=0, le=1e5)] | None = Field(
        default=None,
        description="Largest force of the motor of the fingers' joint [N], where a driver has "
        "forces: one that needs more is stopped (`torque_limit_reached`); null for the joint's own "
        "limit. With a grasp by `contact`, the force that presses each finger on the object",
    )

    @model_validator(mode="after")
    def _contact_has_force(self) -> Self:
        if self.grasp is not None and self.grasp.by == "contact" and self.force is None:
            message = "force: an object that is held by contact needs a `force` that presses it"
            raise ValueError(message)
        return self

    @model_validator(mode="after")
    def _one_goal(self) -> Self:
        if (self.width is None) == (self.grasp is None):
            message = "width: exactly one of `width` and `grasp` must be given"
            raise ValueError(message)
        if self.release is not None and self.width is None:
            message = "release: needs a `width` to open to"
            raise ValueError(message)
        return self

    @property
    def detached(self) -> DetachObject | None:
        """What is let go of, as an operation of the domain."""
        return None if self.release is None else DetachObject(self.release)

    def attached(self, tool_frame: str) -> AttachObject | None:
        """Return how an object is held in the end, as an operation of the domain.

        Args:
            tool_frame: The first one of the group.
        """
        if self.grasp is None:
            return None
        touch = None if self.grasp.touch is None else tuple(self.grasp.touch)
        frame = self.grasp.frame or tool_frame
        return AttachObject(self.grasp.object, frame, touch, grip=self.grip)

    @property
    def grip(self) -> Grip | None:
        """Contact by which an object is held in the end; None for a weld, or for none."""
        if self.grasp is None or self.grasp.by == "weld" or self.force is None:
            return None
        return Grip(self.group, self.force, self.grasp.friction, self.grasp.slip)

    def to_domain(self, tool_frame: str) -> GripperCommand:
        """Return the command for the domain.

        Args:
            tool_frame: The first one of the group.
        """
        command = GripperCommand(self.width, self.attached(tool_frame), self.detached)
        if self.grasp is None:
            return command
        return GripperCommand(
            command.width, command.grasp, command.release, self.grasp.gap, self.grasp.reach
        )
