"""Grip: how a gripper holds an object by friction alone."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Grip(Value):
    """Contact by which a gripper holds an object that is attached to it.

    Proofs and plans take the object to be welded where it is held. A simulated driver has it as a
    free body between the fingers, which are closed by a force, and measures how it moves in them.

    Attributes:
        gripper: The group, `robot::group`.
        force: With which each finger is closed [N].
        friction: Coefficient of Coulomb friction of the object. The one of a contact is
            2 a b / (a + b) with the coefficient b of the finger, which is 1 where its description
            says nothing (Drake's `CombineStaticAndDynamicFriction`).
        slip: Largest distance by which any point of the object may move in the gripper before it
            counts as lost [m].
    """

    gripper: str
    force: float
    friction: float
    slip: float
