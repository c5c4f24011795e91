"""Admission: what must be so before a plan is carried out."""

from service.desk import Desk, spec_of
from service.executions.whereabouts import require_at_start
from service.jobs.key import Key
from service.jobs.records import Job
from service.plans.wire import polynomial_of
from service.scenes.preflight import require_group
from service.scenes.shelf import SceneShelf
from service.schemas.execution import ExecutionRequest

TASK = "service.tasks.execute:execute"


async def submit_execution(
    request: ExecutionRequest, key: str | None, scenes: SceneShelf, desk: Desk
) -> Job:
    """Queue an execution.

    Raises:
        UnknownResource: There is no such plan, or its scene is gone.
        NotFinished: The plan has no trajectory.
        RobotBusy: Another execution moves the group.
        StartMismatch: The plan starts elsewhere.
        QueueFull: The queue is full.
    """
    plan = await desk.job("plan", request.plan)
    polynomial = polynomial_of(plan)
    wanted = plan.payload["request"]
    record = await scenes.get(wanted["scene"], plan.payload["revision"])
    group = require_group(record, wanted["group"])
    asked = request.model_dump(mode="json")
    payload = {
        **{part: plan.payload[part] for part in ("scene", "library")},
        "request": asked,
        "scene_id": record.id,
        "group": group["name"],
        "trajectory": polynomial,
        "speed": request.speed,
        "controls": desk.new_controls(),
    }
    spec = spec_of("execution", TASK, payload, scene=record, key=Key(key, asked))
    # Two requests at once must not both find the robot at rest.
    async with desk.admitting_motion:
        if desk.known(spec) is None:
            start = (plan.result or {})["result"]["start"]
            await require_at_start(desk, record, group, start)
        return desk.submit(spec)
