"""Live states as resources, from the records of their scenes."""

from collections.abc import Mapping

from service.live.models import GripperState, HeldObject, LiveState, RobotState
from service.scenes import live as domain
from service.scenes.models.summary import Group
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
        grippers=[
            state
            for group in record.summary.groups
            if (state := _gripper_state(group, robots, held)) is not None
        ],
    )


def _gripper_state(
    group: Group, robots: Mapping[str, domain.RobotState], held: list[HeldObject]
) -> GripperState | None:
    """Return how wide a group is open that is a gripper, else None."""
    if group.gripper is None:
        return None
    robot, _, joint = group.gripper.joint.partition("::")
    position = robots[robot].positions.get(joint) if robot in robots else None
    if not isinstance(position, float):
        return None
    return GripperState(
        group=group.name,
        robot=robot,
        width=group.gripper.travel * (position - group.gripper.lower),
        max_width=group.gripper.max_width,
        holds=[each.object for each in held if each.frame in group.tool_frames],
    )


def held_objects(record: SceneRecord) -> list[HeldObject]:
    """Return what robots hold in a revision."""
    return [
        HeldObject(object=thing["name"], frame=thing["attached"]["frame"])
        for thing in record.document["objects"]
        if thing.get("attached") is not None
    ]
