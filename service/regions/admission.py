"""Admission: what must be so before regions are grown."""

from planning.domain.request.region_request import validate_one_turn
from planning.errors import UnknownName
from service.job_spec import spec_of
from service.jobs.job import IdempotencyKey, Job
from service.regions.fitness import own_cars, require_fit
from service.scene_jobs import SceneJobs
from service.scenes.preflight import joints_of, require_group
from service.scenes.shelf import SceneShelf
from service.schemas.regions import RegionsRequest

TASK = "service.tasks.regions:grow"

# Growth minds its deadline by itself, between two regions; it is this much too late at most [s].
_SLACK = 60.0


async def submit_regions(
    scene: str, request: RegionsRequest, key: str | None, scenes: SceneShelf, desk: SceneJobs
) -> Job:
    """Queue the growth of regions.

    Raises:
        UnknownResource: There is no such scene or revision.
        UnknownName: The scene has no such group, or the group no such coordinate.
        ProblemInvalid: The group can have no regions, or bounds are wider than a turn.
        IdempotencyConflict: The key was used for another request.
        QueueFull: The queue is full.
    """
    record = await scenes.get(scene, request.revision)
    group = require_group(record, request.group)
    require_fit(group, own_cars(group), "group")
    for name in request.bounds:
        if name not in group["position_names"]:
            raise UnknownName.among("position", name, group["position_names"])
    validate_one_turn(joints_of(group), request.bounds)
    asked = request.model_dump(mode="json")
    payload = {
        **await desk.scene_payload(record),
        "request": asked,
        "revision": record.revision,
    }
    allowed = request.allowed_time + _SLACK
    named = IdempotencyKey(key, {"scene": record.id, **asked})
    return await desk.submit(
        spec_of("regions", TASK, payload, scene=record, key=named, allowed=allowed)
    )
