"""spec_of(): a job about a scene, as the dispatcher takes it."""

from typing import Any

from service.jobs.job import IdempotencyKey, JobSpec
from service.scenes.records import SceneBrief

# Of the ids of each lane's jobs.
PREFIXES = {"plan": "pln", "execution": "exe", "regions": "reg"}
# A robot that has moved is not where a second attempt would begin.
_ATTEMPTS = {"plan": 2, "execution": 1, "regions": 2}


def spec_of(
    lane: str,
    task: str,
    payload: dict[str, Any],
    *,
    scene: SceneBrief,
    key: IdempotencyKey,
    allowed: float | None = None,
) -> JobSpec:
    """Return the spec of a job about a scene."""
    return JobSpec(
        queue=lane,
        task=task,
        payload=payload,
        prefix=PREFIXES[lane],
        scene=scene.id,
        world_digest=scene.digest,
        time_limit=allowed,
        max_attempts=_ATTEMPTS[lane],
        key=key.text,
        request_digest=key.digest,
    )
