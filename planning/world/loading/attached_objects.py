"""Attached objects: objects fixed to a frame of a robot instead of to the world."""

from collections.abc import Collection, Iterable
from typing import Any

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame

from planning.domain.scene.scene import Scene
from planning.domain.scene.scene_tree import parents, root_robot
from planning.errors import SceneInvalid, UnknownName


def validate_owners(scene: Scene, frames: Collection[str]) -> dict[str, str]:
    """Return the robot to which each attached object belongs.

    Args:
        scene: With or without attached objects.
        frames: Full names of everything that an object may be attached to.

    Raises:
        SceneInvalid: The frame does not exist, or is no robot's; evidence has the `path`.
    """
    parent_of = parents(scene)
    owners: dict[str, str] = {}
    for i, thing in enumerate(scene.objects):
        if thing.attached is None:
            continue
        path, frame = f"objects.{i}.attached.frame", thing.attached.frame
        if frame not in frames:
            fault = UnknownName.among("frame", frame, frames)
            raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
        robot = root_robot(frame, parent_of)
        if robot is None:
            message = (
                f"{path}: {frame!r} is not a frame of a robot: objects are attached to robots only"
            )
            raise SceneInvalid(message, {"path": path, "frame": frame})
        owners[thing.name] = robot
    return owners


def allowed_contact_bodies(
    plant: MultibodyPlant, frame: Frame, arm_joints: Iterable[str]
) -> list[BodyIndex]:
    """Return the bodies that an object on `frame` may touch unless the scene says otherwise.

    They are those that move rigidly with it and, if it moves at all, those that they carry: the
    fingers of a gripper.

    Args:
        plant: Finalized.
        frame: The frame that the object is attached to.
        arm_joints: Names of joints at which the search of bodies ends: those of the arm.
    """
    welded_bodies = plant.GetBodiesWeldedTo(frame.body())
    found = {int(body.index()): body.index() for body in welded_bodies}
    if int(plant.world_body().index()) in found:
        return list(found.values())
    stop_joints: set[str] = set(arm_joints)
    joints: list[Any] = [plant.get_joint(index) for index in plant.GetJointIndices()]
    pending = [joint for joint in joints if joint.name() not in stop_joints]
    has_grown = True
    while has_grown:
        has_grown = False
        for joint in pending:
            parent, child = joint.parent_body().index(), joint.child_body().index()
            if int(parent) in found and int(child) not in found:
                found[int(child)] = child
                has_grown = True
    return list(found.values())
