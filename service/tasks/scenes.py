"""Loading a posted scene: whether it stands, and what it holds."""

from typing import Any

from planning import World, load_world, with_line
from planning.errors import SceneInvalid
from service.convert.summaries import scene_wire
from service.tasks.channel import Channel
from service.tasks.decode import decode_scene
from service.tasks.worlds import keep, library_of


def load_scene(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return `document`, `digest` and `summary` of a posted scene; its world stays warm here.

    Raises:
        UnreadableBody: The text is not JSON.
        InputError: The scene has a fault.
    """
    scene, document = decode_scene(payload["text"], payload["media"])
    library = library_of(payload["library"])
    try:
        world = load_world(scene, library)
    except SceneInvalid as fault:
        raise with_line(fault, payload["text"]) from fault
    summary = scene_wire(world.summary, aliases_of(world))
    keep(world, library)
    return {"name": scene.name, "document": document, "digest": scene.digest, "summary": summary}


def aliases_of(world: World) -> dict[str, list[str]]:
    """Return the other names of each group: `robot::group` for a robot's default group."""
    return {
        group.name: [f"{own.robot}::{name}"]
        for own in world.robot_groups
        for name, group in own.groups.items()
        if group.name == own.robot
    }
