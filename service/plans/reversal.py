"""Reversal: a plan's motion backwards, as a plan of its own."""

from typing import Any

from service.job_spec import spec_of
from service.jobs.job import IdempotencyKey, Job
from service.plans.models.request import PlanRequest
from service.plans.resource import polynomial_of
from service.plans.submit import SLACK
from service.scene_jobs import SceneJobs
from service.scenes.shelf import SceneShelf

TASK = "service.plans.reverse_worker:reverse_motion"


async def submit_reversal(plan: Job, key: str | None, scenes: SceneShelf, desk: SceneJobs) -> Job:
    """Queue the way back of a plan.

    Raises:
        NotFinished: The plan has no trajectory.
        UnknownResource: Its scene is gone.
        IdempotencyConflict: The key was used for another request.
        QueueFull: The queue is full.
    """
    polynomial, result = polynomial_of(plan), (plan.result or {})["result"]
    asked: dict[str, Any] = plan.payload["request"]
    record = await scenes.get(asked["scene"], plan.payload["revision"])
    first, *_, last = result["trajectory"]["positions"]
    goal = {"type": "joint", "positions": first}
    request = PlanRequest.model_validate({
        **asked,
        "revision": record.revision,
        "start": last,
        "goal": goal,
    })
    payload = {
        **await desk.scene_payload(record),
        "request": request.model_dump(mode="json"),
        "revision": record.revision,
        # A way back and forth again has the lines of the way there.
        "origin": plan.payload.get("origin", asked),
        "motion": {
            "polynomial": polynomial,
            "path": result["path"],
            "parts": result.get("parts", []),
        },
    }
    allowed = request.search.allowed_planning_time + SLACK
    # Two plans with the same ends have the same way back as a request, but not as a motion.
    named = IdempotencyKey(key, {"reverse": plan.id})
    return await desk.submit(
        spec_of("plan", TASK, payload, scene=record, key=named, allowed=allowed)
    )
