"""Verdicts: whether the motions that are carried out in a scene hold after an edit of it."""

import asyncio
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from planning.errors import InputError, WayproofError
from service.executions.motions.current_motion import CurrentMotion, current_motion
from service.executions.position import last_status
from service.executions.proofs.second_looks import SecondLooks
from service.executions.proofs.tasks import RECHECK, GroupMotion, Recheck, RecheckWork
from service.executions.replanning.replanner import Conflict, Replanner
from service.executions.tasks import Block, Bounds, ExecutionWork
from service.jobs.job import CONTROLS, JobSummary
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.scenes.models.verdicts import ExecutionVerdict
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore

# In one scene; there are mostly none.
_MOST = 100
# Where a motion is left for another one: so far from where the robot is, if the motion holds so
# long [s], and at this share of what holds of it. The rest is for turning away.
_LEAD, _SHARE = 0.1, 0.4
# Check of a verdict that did not come in time.
_UNDECIDED = "undecided"
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Edit:
    """A revision, and what moves in it.

    Attributes:
        record: The scene after the edit.
        motions: Those of all executions.
        scenes: Has its document.
        jobs: Has the executions.
        replanner: Looks for other motions.
        looks: Looks again at what is undecided.
    """

    record: SceneRecord
    motions: Sequence[GroupMotion]
    scenes: SceneStore
    jobs: JobService
    replanner: Replanner
    looks: SecondLooks


async def judge(
    record: SceneRecord,
    *,
    scenes: SceneStore,
    jobs: JobService,
    replanner: Replanner,
    looks: SecondLooks,
) -> list[ExecutionVerdict]:
    """Return for each execution of a scene whether it holds in a revision, and have it heed that.

    Args:
        record: The scene after the edit.
        scenes: Has its document.
        jobs: Has the executions.
        replanner: Looks for other motions of those that are to have one.
        looks: Looks again at those that are undecided, and rest meanwhile.
    """
    pages = [
        await jobs.page("execution", _MOST, None, state=state, scene=record.id)
        for state in (JobState.QUEUED, JobState.RUNNING)
    ]
    # What waits for its robots is proven when it begins.
    found = {
        job.id: job for page in pages for job in page.jobs if not job.payload.get("is_waiting")
    }
    works = {identifier: await _work(identifier, jobs) for identifier in found}
    # One that may have gone on with another motion has all robots: no other is beside it.
    motions = [GroupMotion.of(*each) for each in works.items()]
    edit = _Edit(record, motions, scenes, jobs, replanner, looks)
    verdicts = (_judge(job, works[job.id], edit) for job in found.values())
    return list(await asyncio.gather(*verdicts))


async def _work(identifier: str, jobs: JobService) -> ExecutionWork:
    return ExecutionWork.model_validate((await jobs.job("execution", identifier)).payload)


async def _judge(job: JobSummary, work: ExecutionWork, edit: _Edit) -> ExecutionVerdict:
    jobs, replanner = edit.jobs, edit.replanner
    while True:
        motion = await current_motion(jobs, job, work)
        since = await _place(job, motion, jobs)
        found = await _recheck(job, work, motion, since, edit)
        if (await current_motion(jobs, job, work)).number == motion.number:
            break  # else it has gone on with another one meanwhile
    policy, block = work.request.on_conflict, found.block
    bounds = Bounds(
        revision=edit.record.revision, motion=motion.number, behind=found.behind, ahead=block
    )
    if policy == "replan" and block is not None:
        bounds = bounds.model_copy(update={"leave": _leave(since, block.time)})
    replanner.drop(job.id)
    await _heed(work, bounds, job, jobs)
    if block is None:
        return ExecutionVerdict(id=job.id, verdict="unaffected")
    if block.check == _UNDECIDED and policy in {"slow", "replan"}:
        edit.looks.ask(edit.record.id, edit.record.revision)
    if bounds.leave is not None:
        replanner.begin(Conflict(job, work, motion, bounds))
    return ExecutionVerdict(
        id=job.id,
        verdict="conflict",
        action=policy,
        check=block.check,
        other=block.execution,
        pair=(block.pair[0], block.pair[1]) if block.pair else None,
        time=block.time,
        seconds=max(0.0, block.time - since),
        fraction=block.fraction,
    )


async def _heed(work: ExecutionWork, bounds: Bounds, job: JobSummary, jobs: JobService) -> None:
    """Have an execution heed a verdict."""
    if commands := await _commands(work, bounds, job, jobs):
        try:
            await jobs.control(job, commands)
        except WayproofError as fault:  # it has ended meanwhile
            _log.info("execution %s does not heed an edit: %s", job.id, fault)


async def _place(job: JobSummary, motion: CurrentMotion, jobs: JobService) -> float:
    """Return where on a motion the robot was last [s]; it may be further by now.

    So a little more is looked at than what is left.
    """
    status = await last_status(jobs, job)
    if status is None or status.motion != motion.number:
        return motion.since
    return max(0.0, status.time)


def _leave(since: float, blocked: float) -> float:
    """Return where a motion is to be left for another one [s]: before the half, but not at once."""
    return min(blocked, since + max(_LEAD, _SHARE * (blocked - since)))


async def _commands(
    work: ExecutionWork, bounds: Bounds, job: JobSummary, jobs: JobService
) -> dict[str, Any]:
    """Return what an execution shall do about a verdict, as its request says."""
    policy = work.request.on_conflict
    if policy == "ignore":
        return {}
    if bounds.ahead is not None and policy == "stop":
        return {"block": bounds.ahead.model_dump()}
    if bounds.ahead is None and bounds.behind is None:
        set_before = await jobs.last_recorded(job, CONTROLS)
        if set_before is None or set_before.data.get("bounds") is None:
            return {}
    return {"bounds": bounds.model_dump()}


async def _recheck(
    job: JobSummary, work: ExecutionWork, motion: CurrentMotion, since: float, edit: _Edit
) -> Recheck:
    """Return between which places a motion holds around a time along it."""
    record = edit.record
    # An older version has begun it.
    kept = (work.planned, work.own, work.request.gripper)
    if kept == (None, None, None) and not work.members:
        return _unproven("unknown", since, record)
    loaded = edit.scenes.work(record)
    asked = RecheckWork(
        library=loaded.library,
        scene=loaded.scene,
        planned=work.planned,
        own=work.own,
        members=work.members,
        gripper=work.request.gripper,
        group=work.group,
        trajectory=motion.trajectory,
        since=since,
        revision=record.revision,
        others=[each for each in edit.motions if each.execution != job.id],
        margins=work.margins,
    )
    try:
        return await edit.jobs.call(RECHECK, asked)
    except InputError as fault:  # what it keeps names something that is gone
        _log.info("a motion cannot be proven in revision %d: %s", record.revision, fault)
        return _unproven("request", since, record)
    except WayproofError as fault:
        _log.warning("no verdict on a motion in revision %d: %s", record.revision, fault)
        return _unproven(_UNDECIDED, since, record)


def _unproven(check: str, since: float, record: SceneRecord) -> Recheck:
    """Return the verdict on a motion that nothing is proven of: not proven is not safe."""
    block = Block(check=check, pair=[], time=since, fraction=0.0, revision=record.revision)
    return Recheck(block=block, behind=since)
