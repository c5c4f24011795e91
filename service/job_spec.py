"""spec_of(): a job about a scene, as the dispatcher takes it."""

from typing import Any

from service.jobs.key import Key
from service.jobs.records import JobSpec
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
    key: Key,
    allowed: float | None = None,
) -> JobSpec:
    """Return the spec of a job about a scene."""
    return JobSpec(
        lane=lane,
        task=task,
        payload=payload,
        prefix=PREFIXES[lane],
        scene=scene.id,
        warm_key=scene.digest,
        allowed=allowed,
        max_attempts=_ATTEMPTS[lane],
        key=key.text,
        request_digest=key.digest,
    )
