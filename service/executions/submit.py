"""Queueing the execution of a plan, once it is known to hold."""

from contextlib import suppress
from dataclasses import replace

from service.executions.models import ExecutionRequest
from service.executions.position import require_at_rest, require_at_start
from service.executions.tasks import EXECUTE, PROVE, ExecutionWork, ProofWork
from service.job_spec import spec_of
from service.jobs.errors import Overtaken
from service.jobs.key import IdempotencyKey
from service.jobs.tables import Job, JobSpec
from service.jobs.tasks import TaskModel
from service.plans.models.request import PlanRequest
from service.plans.models.trajectory import Polynomial
from service.plans.resource import motion_of
from service.scene_jobs import SceneJobs
from service.scenes.store import SceneStore
from service.scenes.tasks import SceneWork, StoredScene
from service.scenes.validation import require_group


class _Plan(TaskModel):
    """The part of a plan's stored work that its execution needs."""

    scene: StoredScene
    request: PlanRequest
    origin: PlanRequest | None = None


class _Motion(TaskModel):
    """The part of a plan's result that its execution needs."""

    start: list[float]


class _PlanOutcome(TaskModel):
    """The part of a plan's stored outcome that its execution needs."""

    result: _Motion


async def submit_execution(
    request: ExecutionRequest, key: str | None, scenes: SceneStore, desk: SceneJobs
) -> Job:
    """Queue an execution in the latest revision of the plan's scene.

    Raises:
        UnknownResource: There is no such plan, or its scene is gone.
        UnknownName: The scene has no such group any more.
        NotFinished: The plan has no trajectory.
        RobotBusy: Another execution moves something in the scene.
        StartMismatch: The plan starts elsewhere.
        NotCertified: The motion cannot be proven in the latest revision.
        QueueFull: The queue is full.
    """
    job = await desk.job("plan", request.plan)
    trajectory = motion_of(job).polynomial
    plan, outcome = _Plan.model_validate(job.payload), _PlanOutcome.model_validate(job.result)
    idempotency = IdempotencyKey(key, request.model_dump(mode="json"))
    again = JobSpec(
        EXECUTE.queue, EXECUTE.name, {}, key=idempotency.text, request_digest=idempotency.digest
    )
    while True:
        if (known := await desk.find_by_key(again)) is not None:
            return known
        # Before the scene is read: what ends until then is in it. Of what begins later the database
        # knows, whichever server it was asked of; then all is looked at once more.
        last = await require_at_rest(desk, plan.request.scene)
        record = await scenes.fresh(plan.request.scene)
        group = require_group(record, plan.request.group)
        require_at_start(group, outcome.result.start)
        loaded = await desk.scene_work(record)
        await _check_proven(desk, loaded, plan, trajectory)
        work = ExecutionWork(
            library=loaded.library,
            scene=loaded.scene,
            request=request,
            scene_id=record.id,
            group=group.name,
            trajectory=trajectory,
            speed=request.speed,
        )
        payload = work.model_dump(mode="json")
        spec = spec_of(EXECUTE.queue, EXECUTE.name, payload, scene=record, key=idempotency)
        # The scene is looked up again until this has ended and the scene knows where.
        with suppress(Overtaken), scenes.latest.changing(record.id):
            return await desk.submit(replace(spec, follows=last))


async def _check_proven(
    desk: SceneJobs, scene: SceneWork, plan: _Plan, trajectory: Polynomial
) -> None:
    """Check that the motion is proven in a scene, by the plan's own proof or by a new one.

    Raises:
        NotCertified: It is not.
    """
    if plan.scene.digest == scene.scene.digest:
        return
    work = ProofWork(
        library=scene.library,
        scene=scene.scene,
        request=plan.request,
        origin=plan.origin,
        trajectory=trajectory,
    )
    await desk.call(PROVE, work)
