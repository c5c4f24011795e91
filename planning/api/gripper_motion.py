"""gripper_motion(): open or close a gripper, maybe on an object that it holds afterwards."""

from typing import Any

import numpy as np

from planning.api.retime_path import RetimedPath, retime_path
from planning.domain.request.deadline import Deadline
from planning.domain.request.gripper_command import GripperCommand
from planning.domain.robot.gripper import Gripper
from planning.domain.robot.joints import JointGroup
from planning.domain.scene.scene_operation import AttachObject, DetachObject
from planning.errors import NotCertified, ProblemInvalid
from planning.world.documents.scene_edit import edit_scene
from planning.world.loading.load_world import load_world
from planning.world.mechanics.closing import close_on, require_between
from planning.world.mechanics.grippers import require_gripper
from planning.world.world import World

# Fingers that are nearer than this to where they shall be have nothing to do [m].
_STILL = 1e-6


def gripper_motion(
    world: World,
    group: str,
    command: GripperCommand,
    *,
    deadline: Deadline,
    margin: float | None = None,
) -> RetimedPath:
    """Return the certified motion of a gripper's fingers.

    A motion that closes on an object is proven where that is attached already: fingers may come
    nearer to it than the margin, nothing else may. On the way they stay `gap` away from it. One
    that lets go of an object has to end where the object, once detached, keeps its margins.

    Args:
        world: Loaded scene.
        group: `robot::group`, a gripper.
        command: What it shall do.
        deadline: Time limit.
        margin: Required distance of bodies [m]; None for the scene's.

    Raises:
        UnknownName: There is no such group, object, frame or body.
        ProblemInvalid: The group is no gripper, does not open so wide, or is there already.
        SceneEditImpossible: The object cannot be attached, or is not attached.
        GraspMissed: The fingers do not reach the object, or not all of them do.
        NotCertified: The motion is not proven.
        DeadlineExceeded: Time ran out.
    """
    fingers = world.group(group)
    gripper = require_gripper(world, fingers)
    start = world.positions(fingers)
    goal = np.array([_position(world, fingers, gripper, command)])
    if abs(goal[0] - start[0]) < _STILL:
        message = f"the fingers of {group!r} are {gripper.width(goal[0]):.4g} m apart already"
        raise ProblemInvalid(message, {"field": "width", "width": gripper.width(goal[0])})
    held = holding_world(world, command.grasp)
    if command.release is not None:
        _require_released(world, fingers, goal, command.release, margin)
    return retime_path(held, group, [start, goal], deadline=deadline, margin=margin)


def holding_world(world: World, grasp: AttachObject | None) -> World:
    """Return the world in which an object that is to be grasped is attached; None changes nothing.

    Both belong to one thread.

    Raises:
        UnknownName: There is no such object, frame or body.
        SceneEditImpossible: The object cannot be attached.
    """
    return world if grasp is None else _edited(world, grasp)


def _position(world: World, group: JointGroup, gripper: Gripper, command: GripperCommand) -> float:
    """Return where the gripper's joint shall be [m]."""
    if command.grasp is None:
        if command.width is None:
            message = "width: a gripper needs a `width`, or a `grasp`"
            raise ProblemInvalid(message, {"field": "width"})
        return gripper.position(command.width)
    name = command.grasp.name
    edit_scene(world.scene, [command.grasp], world.library)  # says what cannot be attached
    thing = next(each for each in world.scene.objects if each.name == name)
    if command.grasp.grip is not None and thing.mass is None:
        message = f"object {name!r} is to be held by contact, so it needs a `mass`"
        raise ProblemInvalid(message, {"field": "grasp", "object": name})
    closing = close_on(world, group, gripper, name, command.gap)
    require_between(gripper, name, closing, command.reach)
    return closing.position


def _require_released(
    world: World, group: JointGroup, goal: Any, release: DetachObject, margin: float | None
) -> None:
    """Go on only if an object keeps its margins once it is let go of.

    Raises:
        NotCertified: It does not.
        SceneEditImpossible: It is not attached.
    """
    free = _edited(world, release)
    near = [
        pair
        for pair in free.violations(group, goal, free.margins(margin))
        if release.name in pair.bodies
    ]
    if not near:
        return
    worst = near[0]
    bound = free.margins(margin).of(*worst.bodies)
    message = (
        f"{' and '.join(worst.bodies)} are {worst.distance:.4g} m apart where {bound:.4g} m is the "
        f"margin, so {release.name!r} is not let go of; open wider"
    )
    check = {"name": "release", "value": worst.distance, "bound": bound, "where": release.name}
    evidence = {"check": "release", "pair": list(worst.bodies), "value": worst.distance}
    raise NotCertified(message, {**evidence, "bound": bound, "checks": [check]})


def _edited(world: World, operation: AttachObject | DetachObject) -> World:
    scene = edit_scene(world.scene, [operation], world.library)
    return load_world(scene, world.library, previous=world)
