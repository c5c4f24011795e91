"""Queueing the growth of regions."""

from planning.domain.request.region_request import validate_one_turn
from service.api.fingerprint import fingerprint
from service.jobs.job import IdempotencyKey, Job
from service.jobs.service import JobService
from service.regions.eligibility import check_eligible, own_cars
from service.regions.models import RegionsRequest
from service.regions.tasks import GROW_REGIONS, RegionsWork
from service.scenes.job_spec import spec_of
from service.scenes.store.scene_store import SceneStore
from service.scenes.validation import check_request

# Growth looks at its deadline between two regions; it ends this much too late at most [s].
_SLACK = 60.0


async def submit_regions(
    scene: str, request: RegionsRequest, key: str | None, scenes: SceneStore, jobs: JobService
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
    group = check_request(record, request)
    check_eligible(group, own_cars(group), "group")
    validate_one_turn(group.domain_joints, request.bounds)
    loaded = scenes.work(record)
    work = RegionsWork(
        library=loaded.library, scene=loaded.scene, request=request, revision=record.revision
    )
    idempotency = IdempotencyKey.of(key, lambda: {"scene": record.id, **fingerprint(request)})
    time_limit = request.allowed_time + _SLACK
    spec = spec_of(GROW_REGIONS, work, record, idempotency, time_limit, request.priority)
    return await jobs.submit(spec)
