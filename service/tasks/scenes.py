"""Loading a posted or edited scene: whether it stands, and what it holds."""

from dataclasses import replace
from typing import Any

from planning import (
    ModelLibrary,
    World,
    edit_scene,
    load_world,
    scene_document,
    with_line,
)
from planning.errors import SceneInvalid
from planning.world.trial import tried
from service.convert.scene_edits import operation_value
from service.convert.summaries import scene_wire
from service.schemas.scene_edit import SceneEdit
from service.tasks.channel import Channel
from service.tasks.decode import decode_scene
from service.tasks.scene_files import files_wire, read_posted
from service.tasks.worlds import keep, library_of, load_like, take_world


def load_scene(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return `document`, `digest` and `summary` of a posted scene; its world stays warm here.

    Raises:
        UnreadableBody: The text is not JSON.
        InputError: The scene has a fault.
    """
    scene, document = decode_scene(payload["text"], payload["media"])
    library = library_of(payload["library"])
    try:
        world = load_world(tried(scene, library), library)
    except SceneInvalid as fault:
        raise with_line(fault, payload["text"]) from fault
    return _loaded(world, library, document)


def revise_scene(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return the same of a scene after the operations in `request`.

    Raises:
        UnknownName: An operation names what the scene does not have.
        SceneEditImpossible: An operation cannot be done to it.
        SceneNotKept: It was written before scenes kept their files.
        InputError: What came of it does not load.
    """
    request = SceneEdit.model_validate(payload["request"])
    library = library_of(payload["library"])
    posted, files = read_posted(payload)
    operations = [operation_value(wire) for wire in request.operations]
    world = take_world(payload)
    before = replace(posted.value(), files=files) if world is None else world.scene
    if world is not None:
        keep(world, library)
    edited = edit_scene(before, operations, library)
    document = scene_document(edited, like=posted, before=before)
    scene = tried(replace(document.value_after(posted, before), files=edited.files), library)
    plain = document.model_dump(mode="json", exclude_none=True)
    return _loaded(load_like(scene, library), library, plain)


def _loaded(world: World, library: ModelLibrary, document: dict[str, Any]) -> dict[str, Any]:
    summary = scene_wire(world.summary, aliases_of(world)) | {"files": files_wire(world.scene)}
    keep(world, library)
    name, digest = world.scene.name, world.digest
    return {"name": name, "document": document, "digest": digest, "summary": summary}


def aliases_of(world: World) -> dict[str, list[str]]:
    """Return the other names of each group: `robot::group` for a robot's default group."""
    return {
        group.name: [f"{own.robot}::{name}"]
        for own in world.robot_groups
        for name, group in own.groups.items()
        if group.name == own.robot
    }
