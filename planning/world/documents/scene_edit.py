"""edit_scene(): apply scene operations and return the next revision."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from planning.domain.scene.scene import Attachment, Scene, SceneObject
from planning.domain.scene.scene_operation import (
    AddObject,
    AllowPair,
    AttachObject,
    DetachObject,
    ForbidPair,
    MoveObject,
    RemoveObject,
    SceneOperation,
    SetPositions,
)
from planning.domain.scene.scene_tree import RootAncestor, parents, root_ancestor
from planning.errors import InputError, SceneEditImpossible, SceneInvalid, UnknownName
from planning.world.loading.robot_cache import RobotCache
from planning.world.models.model_library import ModelLibrary

type Editor = Callable[[Scene, RobotCache], Scene]


def edit_scene(
    scene: Scene, operations: Sequence[SceneOperation], library: ModelLibrary | None = None
) -> Scene:
    """Return a scene after some operations, in order; the given one stays as it is.

    Parts that no operation names stay bit for bit. All names in the result exist, so it loads; it
    may be in collision.

    Args:
        scene: A scene that loads.
        operations: Edit operations.
        library: Library of robots; None for those that come with Wayproof.

    Raises:
        UnknownName: An operation names what the scene does not have.
        SceneEditImpossible: An operation cannot be applied to this scene.
    """
    robots = RobotCache(library or ModelLibrary.bundled())
    for i, operation in enumerate(operations):
        try:
            scene = _editor(operation)(scene, robots)
        except SceneInvalid as fault:
            message = f"operations.{i}: {fault.detail}"
            raise SceneEditImpossible(message, {**fault.evidence, "operation": i}) from fault
        except InputError as fault:
            raise type(fault)(
                f"operations.{i}: {fault.detail}", {**fault.evidence, "operation": i}
            ) from fault
    return scene


def _editor(operation: SceneOperation) -> Editor:  # noqa: C901, PLR0911  (one case each)
    match operation:
        case AddObject():
            return partial(_add, operation)
        case MoveObject():
            return partial(_move, operation)
        case RemoveObject():
            return partial(_remove, operation)
        case AttachObject():
            return partial(_attach, operation)
        case DetachObject():
            return partial(_detach, operation)
        case SetPositions():
            return partial(_set_positions, operation)
        case AllowPair():
            return partial(_allow, operation)
        case ForbidPair():
            return partial(_forbid, operation)


def _add(operation: AddObject, scene: Scene, robots: RobotCache) -> Scene:
    thing = operation.scene_object
    names = [entry.name for entry in (*scene.robots, *scene.objects, *scene.frames)]
    if thing.name in {*names, "world"}:
        message = f"the name {thing.name!r} is taken; robots, objects and frames share names"
        raise SceneEditImpossible(message, {"name": thing.name, "known": sorted(names)})
    added = replace(scene, objects=(*scene.objects, thing))
    if thing.attached is not None:
        _resolve_robot_frame(added, robots, thing.attached.frame)
        _validate_bodies(added, robots, thing.attached.touch or ())
    return added


def _move(operation: MoveObject, scene: Scene, _: RobotCache) -> Scene:
    thing = _object(scene, operation.name)
    if thing.attached is not None:
        message = f"{thing.name!r} is attached to {thing.attached.frame!r}; detach it first"
        raise SceneEditImpossible(message, {"name": thing.name, "frame": thing.attached.frame})
    return _with_object(scene, replace(thing, pose=operation.pose))


def _remove(operation: RemoveObject, scene: Scene, _: RobotCache) -> Scene:
    name = _object(scene, operation.name).name
    parent_of = parents(scene)
    descendants = {name}
    while (
        children := {n for n, (parent, _) in parent_of.items() if parent in descendants}
        - descendants
    ):
        descendants |= children
    attached = sorted(thing.name for thing in scene.objects if thing.name in descendants - {name})
    if attached:
        message = f"{attached} are attached to frames below {name!r}; detach them first"
        raise SceneEditImpossible(message, {"name": name, "attached": attached})
    return replace(
        scene,
        objects=tuple(_without_touch(thing, name) for thing in scene.objects if thing.name != name),
        frames=tuple(frame for frame in scene.frames if frame.name not in descendants),
        allowed_collisions=tuple(pair for pair in scene.allowed_collisions if name not in pair),
        margins=tuple(entry for entry in scene.margins if name not in entry.bodies),
        files={of: files for of, files in scene.files.items() if of != name},
    )


def _attach(operation: AttachObject, scene: Scene, robots: RobotCache) -> Scene:
    thing = _object(scene, operation.name)
    if thing.attached is not None:
        message = f"{thing.name!r} is attached to {thing.attached.frame!r} already"
        raise SceneEditImpossible(message, {"name": thing.name, "frame": thing.attached.frame})
    if not thing.movable:
        movable = sorted(entry.name for entry in scene.objects if entry.movable)
        message = f"{thing.name!r} is not `movable`, so it cannot be attached; movable: {movable}"
        raise SceneEditImpossible(message, {"name": thing.name, "movable": movable})
    root = _resolve_robot_frame(scene, robots, operation.frame)
    _validate_bodies(scene, robots, operation.touch or ())
    pose = operation.pose
    if pose is None:
        x_wf = robots.frame_pose(scene, root.root) @ root.pose
        pose = x_wf.inverse @ thing.pose
    how = Attachment(operation.frame, operation.touch, operation.grip)
    attached = replace(thing, pose=pose, attached=how)
    edited = _with_object(scene, attached)
    root_ancestor(attached.name, parents(edited))  # raises if it is its own ancestor
    return edited


def _detach(operation: DetachObject, scene: Scene, robots: RobotCache) -> Scene:
    thing = _object(scene, operation.name)
    if thing.attached is None:
        attached = sorted(entry.name for entry in scene.objects if entry.attached)
        message = f"{thing.name!r} is not attached to anything; attached: {attached}"
        raise SceneEditImpossible(message, {"name": thing.name, "attached": attached})
    root = root_ancestor(thing.name, parents(scene))
    pose = robots.frame_pose(scene, root.root) @ root.pose
    return _with_object(scene, replace(thing, pose=pose, attached=None))


def _set_positions(operation: SetPositions, scene: Scene, robots: RobotCache) -> Scene:
    names = [robot.name for robot in scene.robots]
    if operation.robot not in names:
        raise UnknownName.among("scene robot", operation.robot, names)
    i = names.index(operation.robot)
    placed = robots.with_positions(scene, i, operation.positions)
    return replace(scene, robots=(*scene.robots[:i], placed, *scene.robots[i + 1 :]))


def _allow(operation: AllowPair, scene: Scene, robots: RobotCache) -> Scene:
    _validate_bodies(scene, robots, operation.pair)
    if any(set(pair) == set(operation.pair) for pair in scene.allowed_collisions):
        return scene
    return replace(scene, allowed_collisions=(*scene.allowed_collisions, operation.pair))


def _forbid(operation: ForbidPair, scene: Scene, robots: RobotCache) -> Scene:
    _validate_bodies(scene, robots, operation.pair)
    pairs = tuple(p for p in scene.allowed_collisions if set(p) != set(operation.pair))
    if len(pairs) == len(scene.allowed_collisions):
        message = f"the scene does not allow the pair {list(operation.pair)}: nothing to revoke"
        allowed = [list(pair) for pair in scene.allowed_collisions]
        raise SceneEditImpossible(message, {"pair": list(operation.pair), "allowed": allowed})
    return replace(scene, allowed_collisions=pairs)


def _object(scene: Scene, name: str) -> SceneObject:
    found = next((thing for thing in scene.objects if thing.name == name), None)
    if found is None:
        raise UnknownName.among("object", name, [thing.name for thing in scene.objects])
    return found


def _with_object(scene: Scene, edited: SceneObject) -> Scene:
    names = (thing.name for thing in scene.objects)
    at = next(i for i, name in enumerate(names) if name == edited.name)
    objects = (*scene.objects[:at], edited, *scene.objects[at + 1 :])
    return replace(scene, objects=objects)


def _without_touch(thing: SceneObject, name: str) -> SceneObject:
    if thing.attached is None or name not in (thing.attached.touch or ()):
        return thing
    touch = tuple(body for body in thing.attached.touch or () if body != name)
    return replace(thing, attached=replace(thing.attached, touch=touch))


def _resolve_robot_frame(scene: Scene, robots: RobotCache, frame: str) -> RootAncestor:
    """Return the root ancestor of a frame; raise unless it is a robot's."""
    parent_of = parents(scene)
    links = robots.bodies(scene)
    if frame not in {*parent_of, *links}:
        raise UnknownName.among("frame", frame, [*parent_of, *links])
    root = root_ancestor(frame, parent_of)
    if root.robot is None:
        message = f"{frame!r} is not a frame of a robot: objects are attached to robots only"
        raise SceneEditImpossible(message, {"frame": frame, "hangs_on": root.root})
    return root


def _validate_bodies(scene: Scene, robots: RobotCache, names: Sequence[str]) -> None:
    known = [*robots.bodies(scene), *(thing.name for thing in scene.objects)]
    for name in names:
        if name not in known:
            raise UnknownName.among("body", name, known)
