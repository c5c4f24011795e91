"""Settlement: where an execution leaves its robot becomes the scene's next revision.

So `start: null`, `/check`, `attach` and the guard of the next execution all read one truth, the
latest revision. It is written when the latest revision is first asked for after the end, however
the execution ended, so that nothing is lost if the server ends before.
"""

from service.errors import RevisionConflict
from service.executions.position import last_status
from service.executions.tasks import ExecutionOutline
from service.jobs.job import JobSummary
from service.jobs.service import JobService
from service.scenes.edits import load_edited
from service.scenes.models.edits import SceneEdit, SetPositionsOperation
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore
from service.scenes.validation import find_group


async def settled(
    record: SceneRecord, scenes: SceneStore, jobs: JobService
) -> tuple[SceneRecord, bool]:
    """Return the latest revision of a scene with its robots where executions left them.

    Also whether it stays the latest until something is done to the scene: nothing moves in it.

    Args:
        record: The latest revision as it is stored.
        scenes: Where it is stored.
        jobs: Knows the executions; one at a time moves anything in a scene.

    Raises:
        UnknownResource: The scene is gone.
    """
    while (job := await _last(record, jobs)) is not None:
        if job.finished_at is None:
            return record, False
        edit = await _pending(record, job, jobs)
        if edit is None:
            break
        loaded = await load_edited(record, edit, scenes, jobs)
        try:
            return await scenes.revise(record, loaded), False
        except RevisionConflict:  # another reader was quicker
            record = await scenes.stored(record.id)
    return record, True


async def _last(record: SceneRecord, jobs: JobService) -> JobSummary | None:
    """Return the last execution in a scene, None if there was none."""
    async for job in jobs.newest("execution", scene=record.id):
        return job
    return None


async def _pending(record: SceneRecord, job: JobSummary, jobs: JobService) -> SceneEdit | None:
    """Return what an execution changed and the revision does not know, None if nothing."""
    if job.finished_at is None or job.finished_at <= record.created_at:
        return None
    status = await last_status(jobs, job)
    if status is None:  # it never moved
        return None
    group = find_group(record, ExecutionOutline.model_validate(job.payload).group)
    robot = group.name.partition("::")[0]
    positions = _by_joint(group, robot, status.positions)
    operation = SetPositionsOperation(op="set_positions", robot=robot, positions=positions)
    return SceneEdit(operations=[operation])


def _by_joint(group: Group, robot: str, positions: list[float]) -> dict[str, float | list[float]]:
    """Return measured positions by the joints' names within their robot."""
    found: dict[str, float | list[float]] = {}
    names: list[str] = group.position_names
    for joint in group.joints:
        full: str = joint.name
        own = [
            x
            for name, x in zip(names, positions, strict=True)
            if name == full or name.startswith(f"{full}.")
        ]
        found[full.removeprefix(f"{robot}::")] = own[0] if len(own) == 1 else own
    return found
