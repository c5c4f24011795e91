"""HeldPose: where an object is that a gripper holds by contact, as it was measured."""

from dataclasses import dataclass

from planning.domain.geometry.pose import Pose
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class HeldPose(Value):
    """Where an object is that a gripper holds by contact, as it was measured.

    Attributes:
        name: Of the object.
        frame: F, that it is attached to.
        in_frame: X_FO.
        in_world: X_WO.
        slip: Largest distance of a corner of its bounding box from where proofs take it to be [m].
        bound: Largest slip that does not count as a loss [m].
    """

    name: str
    frame: str
    in_frame: Pose
    in_world: Pose
    slip: float
    bound: float

    @property
    def is_lost(self) -> bool:
        """Whether it has left its place in the gripper."""
        return self.slip > self.bound
