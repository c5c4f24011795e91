"""GripperCommand: what a gripper shall do."""

from dataclasses import dataclass

from planning.domain.scene.scene_operation import AttachObject, DetachObject
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class GripperCommand(Value):
    """What a gripper shall do: exactly one of `width` and `grasp` is given.

    Attributes:
        width: How far apart its fingers shall be [m].
        grasp: The object to close on, and how it is held from the end on.
        release: An object that is let go of by opening to `width`.
        gap: Distance that remains between an object that is grasped and the nearest finger [m].
        reach: Largest distance of any finger from it [m].
    """

    width: float | None = None
    grasp: AttachObject | None = None
    release: DetachObject | None = None
    gap: float = 2e-4
    reach: float = 2e-3
