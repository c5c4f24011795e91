"""GraspKeeper: what a gripper has closed on is attached before its execution has ended.

So who is told of the end finds the object held, or let go of, in the scene: the next plan begins
with it. If it cannot be, as it was removed meanwhile, the execution fails with the reason.
"""

import asyncio

from service.executions.gripping.requests import GripperRequest
from service.executions.motions.gripper_move import tool_frame_of
from service.executions.tasks import EXECUTE, ExecutionOutline
from service.jobs.job import Job
from service.jobs.service import JobService
from service.scenes.edits import apply_edits
from service.scenes.models.edits import AttachOperation, DetachOperation, SceneEdit
from service.scenes.store.scene_store import SceneStore
from service.scenes.validation import find_group


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

    async def keep(self, job: Job) -> None:
        """Attach or detach what a job has grasped or let go of, if it has.

        Args:
            job: That a worker has carried out, and whose end is not recorded yet.

        Raises:
            WayproofError: It cannot be.
        """
        if job.task != EXECUTE.name:
            return
        work = ExecutionOutline.model_validate(job.payload)
        gripper = work.request.gripper
        if gripper is None or (gripper.grasp is None and gripper.release is None):
            return
        await self._opened.wait()
        edit = await self._edit(gripper, work)
        record = await apply_edits(
            work.scene_id, edit, None, self._scenes, self._jobs, execution=job.id
        )
        others = await self._scenes.moving(work.scene_id)
        if any(motion.execution != job.id for motion in others):
            await self._scenes.verdicts(record)

    async def _edit(self, gripper: GripperRequest, work: ExecutionOutline) -> SceneEdit:
        if gripper.release is not None:
            return SceneEdit(operations=[DetachOperation(op="detach", object=gripper.release)])
        group = find_group(await self._scenes.get(work.scene_id), work.group)
        held = gripper.attached(tool_frame_of(group))
        if held is None:
            message = "a gripper that lets go of nothing has grasped something"
            raise AssertionError(message)
        touch = None if held.touch is None else list(held.touch)
        attach = AttachOperation(op="attach", object=held.name, frame=held.frame, touch=touch)
        return SceneEdit(operations=[attach])
