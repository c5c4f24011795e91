"""spec_of(): a task about a scene as a job."""

from typing import Any

from pydantic import BaseModel

from service.jobs.job import IdempotencyKey, JobSpec, Priority
from service.jobs.json_text import Encoded
from service.jobs.task import Task, text_of
from service.scenes.store.records import SceneBrief

# Of the ids of each queue's jobs.
PREFIXES = {"plan": "pln", "execution": "exe", "regions": "reg"}


def spec_of(
    task: Task[Any, Any],
    work: BaseModel,
    scene: SceneBrief,
    key: IdempotencyKey,
    time_limit: float | None = None,
    priority: Priority = Priority.NORMAL,
) -> JobSpec:
    """Return the job that carries a task out in a scene.

    Args:
        task: Of a queue of jobs.
        work: What it is given, or what is known of that while it waits for its robots.
        scene: That it is about.
        key: By which a repeated request finds the same job.
        time_limit: Seconds after which it is told to end; None without one.
        priority: Of what waits.
    """
    return JobSpec(
        queue=task.queue,
        task=task.name,
        payload=Encoded(text_of(work)),
        prefix=PREFIXES[task.queue],
        scene=scene.id,
        world_digest=scene.digest,
        priority=priority.level,
        time_limit=time_limit,
        max_attempts=task.max_attempts,
        key=key.text,
        request_digest=key.digest,
    )
