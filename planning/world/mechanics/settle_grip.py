"""settle_grip(): fingers close on an object by force, and hold it by friction or lose it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.scene.held_pose import HeldPose
from planning.domain.scene.scene_operation import AttachObject, SetPositions
from planning.domain.value import Value
from planning.errors import ProblemInvalid
from planning.world.documents.scene_edit import edit_scene
from planning.world.loading.load_world import load_world
from planning.world.mechanics.simulation import Simulation
from planning.world.world import World


@dataclass(frozen=True, eq=False)
class SettledGrip(Value):
    """Fingers that have closed on an object by force.

    Attributes:
        held: Where the object is; `slip` is from where it stood before.
        positions: Of the gripper's joint [m], shape (1,).
    """

    held: HeldPose
    positions: Float64[np.ndarray, " nq"]


def settle_grip(
    world: World, group: str, q: Float64[np.ndarray, " nq"], grasp: AttachObject
) -> SettledGrip:
    """Return where an object comes to rest in a gripper that closes on it by force.

    It stands where it is until the fingers press, and is let go of then: gravity pulls.

    Args:
        world: Where the object is not attached.
        group: The gripper, `robot::group`.
        q: Its positions, shape (1,): beside the object, as `gripper_motion` leaves it.
        grasp: The object, with a `grip`.

    Raises:
        ProblemInvalid: The robot's default group does not carry the gripper.
        ModelInvalid: The object has no mass, or the robot cannot be simulated.
        SceneEditImpossible: The object cannot be attached.
        TrackingLost: The simulation diverged.
    """
    fingers = world.group(group)
    robot, _, joint = fingers.joints[0].name.partition("::")
    placed = SetPositions(robot, {joint: float(q[0])})
    scene = edit_scene(world.scene, [placed, grasp], world.library)
    closed = load_world(scene, world.library, previous=world)
    arm = closed.group(robot)
    simulation = Simulation(closed, arm, closed.positions(arm))
    held = next((each for each in simulation.held if each.name == grasp.name), None)
    if held is None:
        message = (
            f"{grasp.name!r} is not carried by the default group {arm.name!r} of its robot, or has "
            "no `grip`, so it is not held by contact"
        )
        raise ProblemInvalid(message, {"field": "grasp"})
    return SettledGrip(held, simulation.state_of(fingers))
