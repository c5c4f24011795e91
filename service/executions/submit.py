"""Admission: what must be so before a plan is carried out."""

from typing import Any

from service.executions.models import ExecutionRequest
from service.executions.position import require_at_rest, require_at_start
from service.job_spec import spec_of
from service.jobs.key import IdempotencyKey
from service.jobs.tables import Job, JobSpec
from service.plans.resource import polynomial_of
from service.scene_jobs import SceneJobs
from service.scenes.records import SceneRecord
from service.scenes.store import SceneStore
from service.scenes.validation import require_group

TASK = "service.executions.worker:execute"
PROOF = "service.executions.proof:certify_again"


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
    plan = await desk.job("plan", request.plan)
    polynomial = polynomial_of(plan)
    wanted = plan.payload["request"]
    asked = request.model_dump(mode="json")
    named = IdempotencyKey(key, asked)
    # Two requests at once must not both find the robot at rest.
    async with desk.admitting_motion:
        again = JobSpec("execution", TASK, {}, key=named.text, request_digest=named.digest)
        if (known := await desk.find_by_key(again)) is not None:
            return known
        # Before the scene is read: what ends until then is in it.
        await require_at_rest(desk, wanted["scene"])
        record = await scenes.fresh(wanted["scene"])
        group = require_group(record, wanted["group"])
        require_at_start(group, (plan.result or {})["result"]["start"])
        await _require_proven(desk, record, plan, polynomial)
        payload = {
            **await desk.scene_payload(record),
            "request": asked,
            "scene_id": record.id,
            "group": group.name,
            "trajectory": polynomial,
            "speed": request.speed,
        }
        job = spec_of("execution", TASK, payload, scene=record, key=named)
        # The scene is looked up again until this has ended and the scene knows where.
        with scenes.latest.changing(record.id):
            return await desk.submit(job)


async def _require_proven(
    desk: SceneJobs, record: SceneRecord, plan: Job, polynomial: dict[str, Any]
) -> None:
    """Go on only if the motion is proven in a revision, by the plan's own proof or by a new one.

    Raises:
        NotCertified: It is not.
    """
    if plan.payload["scene"]["digest"] == record.digest:
        return
    payload = {
        **await desk.scene_payload(record),
        "request": plan.payload["request"],
        "origin": plan.payload.get("origin"),
        "trajectory": polynomial,
    }
    await desk.ask(PROOF, payload)
