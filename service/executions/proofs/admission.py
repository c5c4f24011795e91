"""Admission of executions: what they will do is proven in the scene as it is, beside what moves."""

import asyncio
import math
from dataclasses import dataclass

from service.errors import UnknownResource
from service.executions.motions.asked_motion import AskedMotion
from service.executions.position import require_known
from service.executions.proofs.tasks import PROVE_BESIDE, BesideWork, GroupMotion
from service.executions.requests import ExecutionTerms
from service.executions.tasks import EXECUTE, ExecutionWork
from service.jobs.errors import Overtaken
from service.jobs.service import JobService
from service.jobs.store.entries import Entries
from service.scenes.live import joint_types
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore


@dataclass(frozen=True)
class Place:
    """Where an execution is to be carried out.

    Attributes:
        record: The latest revision of its scene, with the robots where they are.
        group: That it moves.
        entries: What moves in the scene, looked up before the record was read.
        address: Of the controller that drives it, where there is one.
    """

    record: SceneRecord
    group: Group
    entries: Entries
    address: str | None


async def proven_work(
    asked: AskedMotion,
    terms: ExecutionTerms,
    place: Place,
    *,
    scenes: SceneStore,
    jobs: JobService,
) -> ExecutionWork:
    """Return an execution whose motion is proven.

    It is proven where the robots are, and beside all that others carry out: every place on its path
    against every place on theirs.

    Args:
        asked: The motion.
        terms: How it is carried out.
        place: Where; none of its robots is moved by another execution.
        scenes: Has the scene.
        jobs: Has the other executions.

    Raises:
        RobotStateUnknown: It is not known where a robot of the scene is.
        StartMismatch: The motion starts elsewhere.
        NotCertified: It cannot be proven.
        ScheduleNotFound: No delays keep several motions apart.
        Overtaken: The scene is not what it was: look again.
    """
    record, group = place.record, place.group
    require_known(record)
    loaded = scenes.work(record)
    proven = await asked.proven(loaded, group, jobs)
    work = ExecutionWork(
        library=loaded.library,
        scene=loaded.scene,
        request=terms,
        scene_id=record.id,
        group=group.name,
        trajectory=proven.trajectory,
        speed=terms.speed,
        joints=joint_types(group),
        delays=proven.delays,
        keeps_at_rest=kept_at_rest(terms, record),
        **asked.demands,
        address=place.address,
        clearance=_finite(proven.min_clearance),
    )
    others = await moving_beside(place.entries, jobs)
    if others:
        beside = BesideWork(
            library=loaded.library,
            scene=loaded.scene,
            motion=GroupMotion.of("", work),
            others=others,
        )
        await jobs.call(PROVE_BESIDE, beside)
    return work


def kept_at_rest(terms: ExecutionTerms, record: SceneRecord) -> list[str]:
    """Return the robots that may not be moved beside an execution.

    One that may go on with another motion has all robots of its scene: what is proven beside its
    motion when that enters is not proven beside the next one.
    """
    if terms.on_conflict != "replan":
        return []
    joints = [joint.name for group in record.summary.groups for joint in group.joints]
    return sorted({name.partition("::")[0] for name in joints})


async def moving_beside(entries: Entries, jobs: JobService) -> list[GroupMotion]:
    """Return the motions of the executions that have entered a scene; not of those that wait.

    Raises:
        Overtaken: One has ended and was deleted since.
    """

    async def motion(execution: str) -> GroupMotion:
        try:
            job = await jobs.job(EXECUTE.queue, execution)
        except UnknownResource:
            raise Overtaken from None
        return GroupMotion.of(execution, ExecutionWork.model_validate(job.payload))

    moving = [entry.job for entry in entries.open if not entry.is_waiting]
    return list(await asyncio.gather(*(motion(job) for job in moving)))


def _finite(clearance: float | None) -> float | None:
    """Return a clearance, None for an infinite one, as JSON has it."""
    return None if clearance is None or math.isinf(clearance) else clearance
