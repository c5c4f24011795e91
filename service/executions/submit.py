"""Queueing the execution of a motion, once it is known to hold."""

import math
from contextlib import suppress
from dataclasses import replace

from planning.errors import NotCertified
from service.api.fingerprint import fingerprint
from service.errors import StartMismatch
from service.executions.controllers import address_of, check_driven
from service.executions.instead import planned_instead
from service.executions.motions import asked_motion
from service.executions.position import require_at_rest, require_known
from service.executions.requests import ExecutionRequest
from service.executions.tasks import EXECUTE, ExecutionWork
from service.jobs.errors import Overtaken
from service.jobs.job import IdempotencyKey, Job, JobSpec
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
        ProblemInvalid: The driver is of another kind of robot.
        UnknownResource: There is no such plan, or its scene is gone.
        UnknownName: The scene has no such group, any more, or the server no such controller.
        NotFinished: The plan has no trajectory.
        RobotBusy: Another execution moves something in the scene.
        RobotStateUnknown: It is not known where a robot of the scene is.
        StartMismatch: The motion starts elsewhere.
        NotCertified: The motion cannot be proven in the latest revision.
        QueueFull: The queue is full.
    """
    jobs = terms.jobs
    address = address_of(request, terms.settings.ur_hosts)
    asked, replanned = await asked_motion(request, jobs), None
    idempotency = IdempotencyKey(key, fingerprint(request))
    again = JobSpec(
        EXECUTE.queue, EXECUTE.name, {}, key=idempotency.text, request_digest=idempotency.digest
    )
    while True:
        if (known := await jobs.find_by_key(again)) is not None:
            return known
        # Before the scene is read: what ends until then is in it. Of what begins later the database
        # knows, whichever server it was asked of; then all is looked at once more.
        last = await require_at_rest(jobs, asked.scene)
        record = await scenes.fresh(asked.scene)
        require_known(record)
        group = asked.group_in(record)
        check_driven(request.driver, group)
        loaded = scenes.work(record)
        try:
            proven = await asked.proven(loaded, group, jobs)
        except (NotCertified, StartMismatch) as fault:
            if request.on_not_certified == "refuse" or replanned is not None:
                raise
            asked, replanned = await planned_instead(asked, fault, terms, scenes)
            continue
        work = ExecutionWork(
            library=loaded.library,
            scene=loaded.scene,
            request=request.terms,
            scene_id=record.id,
            group=group.name,
            trajectory=proven.trajectory,
            speed=request.speed,
            joints=joint_types(group),
            replanned=replanned,
            **asked.demands,
            address=address,
            clearance=_finite(proven.min_clearance),
        )
        spec = spec_of(EXECUTE, work, record, idempotency)
        # The scene is looked up again, and tells where its robot is, until this has ended.
        with suppress(Overtaken), scenes.latest.changing(record.id):
            job = await jobs.submit(replace(spec, follows=last))
            break
    # An edit that was quicker has seen no execution: this one sees it.
    edited = await scenes.fresh(record.id)
    if edited.revision != record.revision:
        await scenes.verdicts(edited)
    return job


def _finite(clearance: float | None) -> float | None:
    """Return a clearance, None for an infinite one, as JSON has it."""
    return None if clearance is None or math.isinf(clearance) else clearance
