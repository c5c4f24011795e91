"""Verdicts: whether the motions that are carried out in a scene hold after an edit of it."""

import asyncio
import logging
from collections.abc import Sequence
from typing import Any

from planning.errors import InputError, WayproofError
from service.executions.position import last_status
from service.executions.tasks import (
    RECHECK,
    Block,
    Bounds,
    ExecutionWork,
    GroupMotion,
    Recheck,
    RecheckWork,
)
from service.jobs.job import CONTROLS, JobSummary
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.scenes.models.verdicts import ExecutionVerdict
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore

# In one scene; there are mostly none.
_MOST = 100
_log = logging.getLogger(__name__)


async def judge(
    record: SceneRecord, *, scenes: SceneStore, jobs: JobService
) -> list[ExecutionVerdict]:
    """Return for each execution of a scene whether it holds in a revision, and have it heed that.

    Args:
        record: The scene after the edit.
        scenes: Has its document.
        jobs: Has the executions.
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
    motions = [GroupMotion.of(*each) for each in works.items()]
    verdicts = (_judge(job, works[job.id], motions, record, scenes, jobs) for job in found.values())
    return list(await asyncio.gather(*verdicts))


async def _work(identifier: str, jobs: JobService) -> ExecutionWork:
    return ExecutionWork.model_validate((await jobs.job("execution", identifier)).payload)


async def _judge(
    job: JobSummary,
    work: ExecutionWork,
    motions: Sequence[GroupMotion],
    record: SceneRecord,
    scenes: SceneStore,
    jobs: JobService,
) -> ExecutionVerdict:
    status = await last_status(jobs, job)
    # The robot may be further by now: what is looked at is a little more than what is left.
    since = 0.0 if status is None else max(0.0, status.time)
    others = [motion for motion in motions if motion.execution != job.id]
    found = await _recheck(work, since, others, record, scenes, jobs)
    commands = await _commands(work, found, record, job, jobs)
    if commands:
        try:
            await jobs.control(job, commands)
        except WayproofError as fault:  # it has ended meanwhile
            _log.info("execution %s does not heed an edit: %s", job.id, fault)
    if (block := found.block) is None:
        return ExecutionVerdict(id=job.id, verdict="unaffected")
    return ExecutionVerdict(
        id=job.id,
        verdict="conflict",
        action=work.request.on_conflict,
        check=block.check,
        other=block.execution,
        pair=(block.pair[0], block.pair[1]) if block.pair else None,
        time=block.time,
        seconds=max(0.0, block.time - since),
        fraction=block.fraction,
    )


async def _commands(
    work: ExecutionWork, found: Recheck, record: SceneRecord, job: JobSummary, jobs: JobService
) -> dict[str, Any]:
    """Return what an execution shall do about a verdict, as its request says."""
    policy = work.request.on_conflict
    if policy == "ignore":
        return {}
    if found.block is not None and policy == "stop":
        return {"block": found.block.model_dump()}
    bounds = Bounds(revision=record.revision, behind=found.behind, ahead=found.block)
    if found.block is None and found.behind is None:
        set_before = await jobs.last_recorded(job, CONTROLS)
        if set_before is None or set_before.data.get("bounds") is None:
            return {}
    return {"bounds": bounds.model_dump()}


async def _recheck(
    work: ExecutionWork,
    since: float,
    others: list[GroupMotion],
    record: SceneRecord,
    scenes: SceneStore,
    jobs: JobService,
) -> Recheck:
    """Return between which places a motion holds around a time along it."""
    # An older version has begun it.
    if work.planned is None and work.own is None and not work.members:
        return _unproven("unknown", since, record)
    loaded = scenes.work(record)
    asked = RecheckWork(
        library=loaded.library,
        scene=loaded.scene,
        planned=work.planned,
        own=work.own,
        members=work.members,
        group=work.group,
        trajectory=work.trajectory,
        since=since,
        revision=record.revision,
        others=others,
        margins=work.margins,
    )
    try:
        return await jobs.call(RECHECK, asked)
    except InputError as fault:  # what it keeps names something that is gone
        _log.info("a motion cannot be proven in revision %d: %s", record.revision, fault)
        return _unproven("request", since, record)
    except WayproofError as fault:
        _log.warning("no verdict on a motion in revision %d: %s", record.revision, fault)
        return _unproven("undecided", since, record)


def _unproven(check: str, since: float, record: SceneRecord) -> Recheck:
    """Return the verdict on a motion that nothing is proven of: not proven is not safe."""
    block = Block(check=check, pair=[], time=since, fraction=0.0, revision=record.revision)
    return Recheck(block=block, behind=since)
