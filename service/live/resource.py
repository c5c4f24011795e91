"""Live states as resources, from the records of their scenes."""

from collections.abc import Mapping

from service.live.models import HeldObject, LiveState, RobotState
from service.scenes import live as domain
from service.scenes.store.records import SceneRecord


def live_state(
    record: SceneRecord, robots: Mapping[str, domain.RobotState], held: list[HeldObject]
) -> LiveState:
    """Return the live state of a scene.

    Args:
        record: Its latest revision.
        robots: Where its robots are, by name.
        held: What they hold.
    """
    return LiveState(
        scene=record.id,
        revision=record.revision,
        robots=[RobotState.of(state) for state in robots.values()],
        attached=held,
    )


def held_objects(record: SceneRecord) -> list[HeldObject]:
    """Return what robots hold in a revision."""
    return [
        HeldObject(object=thing["name"], frame=thing["attached"]["frame"])
        for thing in record.document["objects"]
        if thing.get("attached") is not None
    ]
