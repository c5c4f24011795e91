"""Live states as resources, from the records of their scenes."""

from collections.abc import Mapping

from planning.domain.scene.scene import SceneObject
from planning.world.documents.scene_document import ObjectDocument
from service.executions.gripping.held import HeldStatus, MeasuredPose
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
        held: What they hold in that revision.
    """
    held = _measured(held, robots)
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
        _held_object(ObjectDocument.model_validate(thing).value())
        for thing in record.document["objects"]
        if thing.get("attached") is not None
    ]


def _held_object(thing: SceneObject) -> HeldObject:
    attached = thing.attached
    return HeldObject(
        object=thing.name,
        frame="" if attached is None else attached.frame,
        by="weld" if attached is None or attached.grip is None else "contact",
        pose=MeasuredPose.of(thing.pose),
    )


def _measured(held: list[HeldObject], robots: Mapping[str, domain.RobotState]) -> list[HeldObject]:
    """Return what robots hold, where it was measured last."""
    told = [HeldStatus.model_validate(one) for state in robots.values() for one in state.held]
    known = {one.object: one for one in told}
    return [
        each
        if (one := known.get(each.object)) is None
        else each.model_copy(update={"pose": one.pose, "slip": one.slip, "is_lost": one.is_lost})
        for each in held
    ]
