"""GraspKeeper: what a gripper holds, and how, is in the scene before its execution has ended.

So who is told of the end finds the object held, let go of, or where it has slipped to: the next
plan begins with it. If it cannot be, as it was removed meanwhile, the execution fails with the
reason. Of an execution that a server has left, the last status says whether its motion had
succeeded: then it is held, and the execution has succeeded; else neither.
"""

import asyncio
from typing import Any

from service.executions.gripping.held import HeldStatus
from service.executions.gripping.requests import GripperRequest
from service.executions.models import ExecutionState, ExecutionStatus
from service.executions.motions.gripper_move import tool_frame_of
from service.executions.tasks import EXECUTE, ExecutionOutcome, ExecutionOutline
from service.jobs.dispatch.conclusion import LastEvent
from service.jobs.job import Job
from service.jobs.json_text import Encoded
from service.jobs.service import JobService
from service.scenes.edits import apply_edits
from service.scenes.models.edits import SceneEdit
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore
from service.scenes.validation import find_group

# What slips by less is where it was, to the accuracy of a simulation [m].
_MOVED = 1e-4


class GraspKeeper:
    """Edits scenes on behalf of executions that have reached their end."""

    def __init__(self) -> None:
        """Have no records yet; `open` brings them."""
        self._opened = asyncio.Event()
        self._scenes: SceneStore
        self._jobs: JobService

    def open(self, scenes: SceneStore, jobs: JobService) -> None:
        """Begin to work: what has ended before waits for this."""
        self._scenes, self._jobs = scenes, jobs
        self._opened.set()

    def concerns(self, job: Job, last: LastEvent) -> bool:
        """Return whether a job may change what is held."""
        if job.task != EXECUTE.name:
            return False
        gripper = ExecutionOutline.model_validate(job.payload).request.gripper
        takes = gripper is not None and (gripper.grasp is not None or gripper.release is not None)
        return takes or bool((last("status") or {}).get("held"))

    async def conclude(self, job: Job, last: LastEvent, *, has_succeeded: bool) -> None:
        """Attach or detach what a job has grasped or let go of, and move what has slipped.

        Args:
            job: That a worker has carried out, and whose end is not recorded yet.
            last: Its last events.
            has_succeeded: Whether its motion has.

        Raises:
            WayproofError: It cannot be.
        """
        work = ExecutionOutline.model_validate(job.payload)
        status = last("status") or {}
        held = [HeldStatus.model_validate(each) for each in status.get("held", ())]
        await self._opened.wait()
        record = await self._scenes.get(work.scene_id)
        gripper = work.request.gripper
        if has_succeeded and gripper is not None:
            operations = _taken(gripper, work, record, held)
        else:
            operations = _slipped(held, record)
        if not operations:
            return
        edit = SceneEdit.model_validate({"operations": operations})
        record = await apply_edits(
            work.scene_id, edit, None, self._scenes, self._jobs, execution=job.id
        )
        others = await self._scenes.moving(work.scene_id)
        if any(motion.execution != job.id for motion in others):
            await self._scenes.verdicts(record)

    async def recovered(self, job: Job, last: LastEvent) -> Encoded | None:
        """Have what a left job holds in the scene, if its motion had succeeded.

        Returns:
            The outcome of the execution; None if its motion had not succeeded.

        Raises:
            WayproofError: It had, and what it holds cannot be attached.
        """
        status = ExecutionStatus.model_validate(last("status") or {}) if last("status") else None
        has_succeeded = status is not None and status.state is ExecutionState.SUCCEEDED
        await self.conclude(job, last, has_succeeded=has_succeeded)
        if status is None or not has_succeeded:
            return None
        return Encoded(ExecutionOutcome(status=status).model_dump_json())


def _taken(
    gripper: GripperRequest, work: ExecutionOutline, record: SceneRecord, held: list[HeldStatus]
) -> list[dict[str, Any]]:
    """Return the operations by which an object is held, or is no more; none if they are done."""
    if gripper.release is not None:
        is_held = _attached(record, gripper.release) is not None
        return [{"op": "detach", "object": gripper.release}] if is_held else []
    grasp = gripper.attached(tool_frame_of(find_group(record, work.group)))
    if grasp is None:
        return []
    if (_attached(record, grasp.name) or {}).get("frame") == grasp.frame:
        return []  # by a server that did not come to record the end
    touch = None if grasp.touch is None else list(grasp.touch)
    attach = {"op": "attach", "object": grasp.name, "frame": grasp.frame, "touch": touch}
    measured = next((each for each in held if each.object == grasp.name), None)
    if measured is None or gripper.grip is None:
        return [attach]
    return [attach | _where(measured) | {"grip": _grip_document(gripper)}]


def _grip_document(gripper: GripperRequest) -> dict[str, Any]:
    grip = gripper.grip
    if grip is None:
        return {}
    return {
        "gripper": grip.gripper,
        "force": grip.force,
        "friction": grip.friction,
        "slip": grip.slip,
    }


def _where(measured: HeldStatus) -> dict[str, Any]:
    """Return the fields of `attach` that say where an object was measured to be held."""
    return {"keep": False, "pose": measured.pose.model_dump()}


def _slipped(held: list[HeldStatus], record: SceneRecord) -> list[dict[str, Any]]:
    """Return the operations by which objects are where they were measured."""
    operations: list[dict[str, Any]] = []
    for each in held:
        attached = _attached(record, each.object)
        detach = [] if attached is None else [{"op": "detach", "object": each.object}]
        if each.is_lost:
            pose = each.world_pose.model_dump()
            operations += [*detach, {"op": "move", "object": each.object, "pose": pose}]
        elif attached is not None and each.slip > _MOVED:
            again = {"op": "attach", "object": each.object, **attached, **_where(each)}
            operations += [*detach, again]
    return operations


def _attached(record: SceneRecord, name: str) -> dict[str, Any] | None:
    """Return the attachment of an object in a revision; None if there is none."""
    found = [thing for thing in record.document["objects"] if thing["name"] == name]
    return found[0].get("attached") if found else None
