"""Queueing the execution of a plan, once it is known to hold."""

from contextlib import suppress
from dataclasses import replace

from service.executions.models import ExecutionRequest
from service.executions.position import check_at_start, require_at_rest, require_known
from service.executions.tasks import EXECUTE, PROVE, ExecutionWork, ProofWork
from service.jobs.errors import Overtaken
from service.jobs.job import IdempotencyKey, Job, JobSpec
from service.jobs.service import JobService
from service.plans.models.trajectory import Polynomial
from service.plans.resource import motion_of, work_of
from service.plans.tasks import MotionWork
from service.scenes.job_spec import spec_of
from service.scenes.live import joint_types
from service.scenes.store.scene_store import SceneStore
from service.scenes.tasks import SceneWork
from service.scenes.validation import find_group


async def submit_execution(
    request: ExecutionRequest, key: str | None, scenes: SceneStore, jobs: JobService
) -> Job:
    """Queue an execution in the latest revision of the plan's scene.

    Raises:
        UnknownResource: There is no such plan, or its scene is gone.
        UnknownName: The scene has no such group any more.
        NotFinished: The plan has no trajectory.
        RobotBusy: Another execution moves something in the scene.
        RobotStateUnknown: It is not known where a robot of the scene is.
        StartMismatch: The plan starts elsewhere.
        NotCertified: The motion cannot be proven in the latest revision.
        QueueFull: The queue is full.
    """
    job = await jobs.job("plan", request.plan)
    motion, plan = motion_of(job), work_of(job)
    idempotency = IdempotencyKey(key, request.model_dump(mode="json"))
    again = JobSpec(
        EXECUTE.queue, EXECUTE.name, {}, key=idempotency.text, request_digest=idempotency.digest
    )
    while True:
        if (known := await jobs.find_by_key(again)) is not None:
            return known
        # Before the scene is read: what ends until then is in it. Of what begins later the database
        # knows, whichever server it was asked of; then all is looked at once more.
        last = await require_at_rest(jobs, plan.request.scene)
        record = await scenes.fresh(plan.request.scene)
        require_known(record)
        group = find_group(record, plan.request.group)
        check_at_start(group, motion.result.start)
        loaded = scenes.work(record)
        await _check_proven(jobs, loaded, plan, motion.polynomial)
        work = ExecutionWork(
            library=loaded.library,
            scene=loaded.scene,
            request=request,
            scene_id=record.id,
            group=group.name,
            trajectory=motion.polynomial,
            speed=request.speed,
            joints=joint_types(group),
        )
        spec = spec_of(EXECUTE, work, record, idempotency)
        # The scene is looked up again, and tells where its robot is, until this has ended.
        with suppress(Overtaken), scenes.latest.changing(record.id):
            return await jobs.submit(replace(spec, follows=last))


async def _check_proven(
    jobs: JobService, scene: SceneWork, plan: MotionWork, trajectory: Polynomial
) -> None:
    """Check that the motion is proven in a scene, by the plan's own proof or by a new one.

    Raises:
        NotCertified: It is not.
    """
    if plan.scene.is_same(scene.scene):
        return
    work = ProofWork(
        library=scene.library,
        scene=scene.scene,
        request=plan.request,
        origin=plan.origin,
        trajectory=trajectory,
    )
    await jobs.call(PROVE, work)
