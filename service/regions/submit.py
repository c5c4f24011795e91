"""Queueing the growth of regions."""

from planning.domain.request.region_request import validate_one_turn
from planning.errors import UnknownName
from service.job_spec import spec_of
from service.jobs.key import IdempotencyKey
from service.jobs.tables import Job
from service.regions.eligibility import check_eligible, own_cars
from service.regions.models import RegionsRequest
from service.regions.tasks import GROW_REGIONS, RegionsWork
from service.scene_jobs import SceneJobs
from service.scenes.store import SceneStore
from service.scenes.validation import joints_of, require_group

# Growth looks at its deadline between two regions; it ends this much too late at most [s].
_SLACK = 60.0


async def submit_regions(
    scene: str, request: RegionsRequest, key: str | None, scenes: SceneStore, desk: SceneJobs
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
    check_eligible(group, own_cars(group), "group")
    for name in request.bounds:
        if name not in group.position_names:
            raise UnknownName.among("position", name, group.position_names)
    validate_one_turn(joints_of(group), request.bounds)
    loaded = await desk.scene_work(record)
    work = RegionsWork(
        library=loaded.library, scene=loaded.scene, request=request, revision=record.revision
    )
    payload = work.model_dump(mode="json")
    return await desk.submit(
        spec_of(
            GROW_REGIONS.queue,
            GROW_REGIONS.name,
            payload,
            scene=record,
            key=IdempotencyKey(key, {"scene": record.id, **payload["request"]}),
            allowed=request.allowed_time + _SLACK,
        )
    )
