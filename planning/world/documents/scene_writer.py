"""scene_document(): write a scene as a scene document."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from typing import Any

from pydantic import ValidationError

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)
from planning.domain.scene.scene import Attachment, Scene, SceneFrame, SceneObject, SceneRobot
from planning.world.documents.scene_document import ObjectDocument, SceneDocument
from planning.world.documents.scene_file import parse_scene


def scene_document(scene: Scene, previous: SceneDocument | None = None) -> SceneDocument:
    """Return the document of a scene.

    Read again it gives the same scene, but for the last bit of quaternions that are normalised
    once more.

    Args:
        scene: The scene.
        previous: A document of an earlier revision: unchanged robots, objects and frames keep its
            text, bit for bit.

    Raises:
        SceneInvalid: The scene has what no document may have, such as too many objects.
    """
    content = _scene_content(replace(scene, objects=()))
    objects: Sequence[Any] = [_object(thing) for thing in scene.objects]
    if previous is not None:
        content["robots"] = _reused(content["robots"], scene.robots, previous.robots)
        content["frames"] = _reused(content["frames"], scene.frames, previous.frames)
        objects = _reused_objects(scene.objects, previous.objects)
    try:
        return SceneDocument.model_validate({**content, "objects": objects})
    except ValidationError:
        parse_scene({**content, "objects": list(map(_object, scene.objects))})  # raises the reason
        raise


def object_document(thing: SceneObject) -> ObjectDocument:
    """Return the document of an object.

    Raises:
        ValidationError: It is invalid as a document.
    """
    return ObjectDocument.model_validate(_object(thing))


def _scene_content(scene: Scene) -> dict[str, Any]:
    return {
        "name": scene.name,
        "robots": [_robot(robot) for robot in scene.robots],
        "objects": [_object(thing) for thing in scene.objects],
        "frames": [_frame(frame) for frame in scene.frames],
        "allowed_collisions": [list(pair) for pair in scene.allowed_collisions],
        "groups": {group.name: list(group.members) for group in scene.groups},
        "configurations": {
            entry.name: {"group": entry.group, "positions": entry.positions.tolist()}
            for entry in scene.configurations
        },
        "margin": scene.margin,
        "margins": [
            {"bodies": list(entry.bodies), "margin": entry.margin} for entry in scene.margins
        ],
    }


def _reused_objects(
    values: Sequence[SceneObject], documents: Sequence[ObjectDocument]
) -> list[ObjectDocument | dict[str, Any]]:
    """Return the documents of objects, from the earlier document for unchanged ones."""
    earlier = {document.name: document for document in documents}
    return [
        known
        if (known := earlier.get(value.name)) is not None and known.value() == value
        else _object(value)
        for value in values
    ]


def _reused(content: list[Any], values: Iterable[Any], documents: Iterable[Any]) -> list[Any]:
    """Return new documents, replaced by the earlier ones where the values are equal."""
    earlier = {document.name: document for document in documents}
    return [
        earlier[value.name].model_dump()
        if value.name in earlier and earlier[value.name].value() == value
        else entry
        for entry, value in zip(content, values, strict=True)
    ]


def _robot(robot: SceneRobot) -> dict[str, Any]:
    positions = list(robot.positions) if isinstance(robot.positions, tuple) else robot.positions
    base = _pose(robot.base)
    content = {"name": robot.name, "model": robot.model, "base": base, "positions": positions}
    return {**content, "weld": robot.weld}


def _object(thing: SceneObject) -> dict[str, Any]:
    return {
        "name": thing.name,
        "shape": _shape(thing.shape),
        "pose": _pose(thing.pose),
        "movable": thing.movable,
        "color": None if thing.color is None else thing.color.tolist(),
        "attached": thing.attached and _attachment(thing.attached),
        "mass": thing.mass,
        "center_of_mass": None if thing.center_of_mass is None else thing.center_of_mass.tolist(),
    }


def _attachment(attached: Attachment) -> dict[str, Any]:
    held = {"frame": attached.frame, "touch": attached.touch}
    return held if attached.grip is None else {**held, "grip": asdict(attached.grip)}


def _frame(frame: SceneFrame) -> dict[str, Any]:
    return {"name": frame.name, "parent": frame.parent, "pose": _pose(frame.pose)}


def _pose(pose: Pose) -> dict[str, Any]:
    return {"position": pose.position.tolist(), "quaternion": pose.quaternion.tolist()}


def _shape(shape: Shape) -> dict[str, Any]:  # noqa: C901, PLR0911  (one case per shape)
    match shape:
        case Box():
            return {"box": shape.size.tolist()}
        case Sphere():
            return {"sphere": shape.radius}
        case Cylinder():
            return {"cylinder": {"radius": shape.radius, "length": shape.length}}
        case Capsule():
            return {"capsule": {"radius": shape.radius, "length": shape.length}}
        case Ellipsoid():
            return {"ellipsoid": shape.semi_axes.tolist()}
        case HalfSpace():
            return {"half_space": {}}
        case Convex():
            return {"convex": {"points": shape.points.tolist()}}
        case Mesh():
            return {"mesh": {"uri": shape.uri, "scale": shape.scale.tolist()}}
