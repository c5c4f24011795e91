"""Queueing the execution of a motion, once it is known to hold, or to wait for its robots."""

from contextlib import suppress
from dataclasses import replace

from planning.errors import NotCertified
from service.api.fingerprint import fingerprint
from service.errors import RobotBusy, StartMismatch
from service.executions.drivers.controllers import address_of, check_driven
from service.executions.motions.requested_motion import asked_motion
from service.executions.proofs.admission import Place, kept_at_rest, proven_work
from service.executions.replanning.planned_instead import planned_instead
from service.executions.requests import ExecutionRequest
from service.executions.tasks import EXECUTE, ExecutionOutline, ExecutionWork, WaitingExecution
from service.jobs.errors import Overtaken
from service.jobs.job import IdempotencyKey, Job, JobSpec
from service.jobs.service import JobService
from service.jobs.store.entries import OpenEntry
from service.plans.submit import PlanTerms
from service.scenes.job_spec import spec_of
from service.scenes.live import joint_types
from service.scenes.store.scene_store import SceneStore


async def submit_execution(
    request: ExecutionRequest,
    key: str | None,
    scenes: SceneStore,
    terms: PlanTerms,
) -> Job:
    """Queue an execution in the latest revision of its motion's scene.

    Args:
        request: What is asked for.
        key: By which a repeated request finds the same job.
        scenes: Knows the scene.
        terms: Know the plan and all executions, and addresses of controllers.

    Raises:
        ProblemInvalid: The driver is of another kind of robot, or plans do not fit each other.
        UnknownResource: There is no such plan, or its scene is gone.
        UnknownName: The scene has no such group, any more, or the server no such controller.
        NotFinished: The plan has no trajectory.
        RobotBusy: Another execution moves one of its robots, or waits for it.
        RobotStateUnknown: It is not known where a robot of the scene is.
        StartMismatch: The motion starts elsewhere.
        NotCertified: The motion cannot be proven in the latest revision, beside what moves there.
        QueueFull: The queue is full.
    """
    jobs = terms.jobs
    address = address_of(request, terms.settings.ur_hosts)
    asked, replanned = await asked_motion(request, jobs), None
    idempotency = IdempotencyKey.of(key, lambda: fingerprint(request))
    again = JobSpec(
        EXECUTE.queue, EXECUTE.name, {}, key=idempotency.text, request_digest=idempotency.digest
    )
    while True:
        if (known := await jobs.find_by_key(again)) is not None:
            return known
        # Before the scene is read: what ends until then is in it. Of what enters later the database
        # knows, whichever server it was asked of; then all is looked at once more.
        entries = await jobs.entries(EXECUTE.queue, asked.scene)
        record = await scenes.fresh(asked.scene)
        group = asked.group_in(record)
        check_driven(request.driver, group)
        place = Place(record, group, entries, address)
        outline = _waiting(request, place, scenes)
        busy = entries.in_the_way(outline.held_robots)
        if busy is not None and request.when_busy == "refuse":
            raise await _busy(busy, jobs)
        with suppress(Overtaken):
            work: WaitingExecution | ExecutionWork = outline
            if busy is None:
                try:
                    work = await proven_work(asked, request.terms, place, scenes=scenes, jobs=jobs)
                except (NotCertified, StartMismatch) as fault:
                    if request.on_not_certified == "refuse" or replanned is not None:
                        raise
                    asked, replanned = await planned_instead(asked, fault, terms, scenes)
                    continue
                work = work.model_copy(update={"replanned": replanned})
            spec = replace(
                spec_of(EXECUTE, work, record, idempotency),
                follows=entries.number,
                robots=outline.held_robots,
                waits=busy is not None,
            )
            # The scene is looked up again, and tells where its robot is, until this has ended.
            with scenes.latest.changing(record.id):
                job = await jobs.submit(spec)
            break
    # An edit that was quicker has seen no execution: this one sees it.
    edited = await scenes.fresh(record.id)
    if edited.revision != record.revision:
        await scenes.verdicts(edited)
    return job


def _waiting(request: ExecutionRequest, place: Place, scenes: SceneStore) -> WaitingExecution:
    """Return an execution that waits for its robots: nothing is proven of it yet."""
    loaded = scenes.work(place.record)
    return WaitingExecution(
        library=loaded.library,
        scene=loaded.scene,
        request=request.terms,
        scene_id=place.record.id,
        group=place.group.name,
        speed=request.speed,
        joints=joint_types(place.group),
        is_waiting=True,
        keeps_at_rest=kept_at_rest(request.terms, place.record),
        own=request.trajectory,
        address=place.address,
    )


async def _busy(entry: OpenEntry, jobs: JobService) -> RobotBusy:
    """Return the refusal of a motion whose robot another execution has."""
    job = await jobs.open_job(EXECUTE.queue, entry.job)
    group = ExecutionOutline.model_validate(job.payload).group
    does = "waits for" if entry.is_waiting else "moves"
    message = (
        f"execution {job.id} {does} {group}; wait for its end, cancel it, or have this one wait "
        "(`when_busy`)"
    )
    return RobotBusy(message, {"execution": job.id, "group": group})
