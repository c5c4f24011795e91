"""Batches: plans that were asked for together. All that makes them one is an id in their rows."""

import asyncio
import secrets
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from planning.errors import InputError, UnknownName, WayproofError
from service.api.names import located
from service.api.submission import Submission
from service.errors import Refusal, UnknownResource
from service.jobs.job import BatchMember, IdempotencyKey, JobSpec
from service.jobs.service import JobService
from service.plans.models.batch import Batch, BatchCounts, BatchRequest
from service.plans.models.request import PlanRequest
from service.plans.submit import plan_spec
from service.scenes.store.scene_store import SceneStore

_PREFIX = "bat_"


async def submit_batch(request: BatchRequest, submission: Submission, scenes: SceneStore) -> str:
    """Queue a plan for each problem, all or none, and return the id of the batch.

    Raises:
        InputError: A problem names what there is not, or is wrong otherwise.
        Refusal: A scene is not there, or is in no state for its problem.
        IdempotencyConflict: The key was used for another request.
        QueueFull: The queue has no room for all of them.
    """
    batch = f"{_PREFIX}{secrets.token_hex(8)}"
    specs = [
        await _spec(k, problem, submission, scenes) for k, problem in enumerate(request.problems)
    ]
    specs = [replace(spec, batch=batch) for spec in specs]
    # The key of the whole batch is that of its first plan: keys are of jobs.
    key = IdempotencyKey.of(submission.key, lambda: {"batch": request.model_dump(mode="json")})
    specs[0] = replace(specs[0], key=key.text, request_digest=key.digest)
    jobs = await submission.jobs.submit_all(specs)
    return jobs[0].batch or batch


async def members_of(jobs: JobService, batch: str) -> Sequence[BatchMember]:
    """Return the plans of a batch in the order of its problems.

    Raises:
        UnknownResource: There is no such batch, or all its plans were deleted.
    """
    members = await jobs.members_of(batch) if batch.startswith(_PREFIX) else []
    if not members:
        raise UnknownResource.of("batch", batch)
    return members


async def cancel_batch(jobs: JobService, members: Sequence[BatchMember]) -> None:
    """End all plans that have not ended; what waits is told before what runs makes room."""
    still_open = [member for member in members if not member.state.is_final]
    await asyncio.gather(*(jobs.cancel(member) for member in reversed(still_open)))


def batch_resource(batch: str, members: Sequence[BatchMember]) -> Batch:
    """Return a batch as clients see it."""
    ends = [member.finished_at for member in members if member.finished_at is not None]
    return Batch(
        id=batch,
        plans=[member.id for member in members],
        counts=BatchCounts(**Counter(member.state.value for member in members)),
        created_at=members[0].created_at,
        finished_at=max(ends) if len(ends) == len(members) else None,
    )


async def _spec(
    k: int, problem: PlanRequest, submission: Submission, scenes: SceneStore
) -> JobSpec:
    """Return the job of the k-th problem; raises as `plan_spec`, with pointers into the batch."""
    try:
        return await plan_spec(problem, IdempotencyKey(None, {}), submission, scenes)
    except (InputError, Refusal) as fault:
        raise _within(k, fault, problem) from fault


def _within(k: int, fault: WayproofError, problem: PlanRequest) -> WayproofError:
    """Return the error of a problem with pointers into the whole request."""
    if isinstance(fault, UnknownName) and "errors" not in fault.evidence:
        fault = located(fault, problem.model_dump(mode="json", exclude_unset=True))
    evidence: dict[str, Any] = dict(fault.evidence)
    field = evidence.get("field")
    pointer = "" if field is None else f"/{field.replace('.', '/')}"
    errors = evidence.get("errors") or [
        {"pointer": pointer, "message": fault.detail, "nearest": evidence.get("nearest", [])}
    ]
    evidence["errors"] = [{**one, "pointer": f"/problems/{k}{one['pointer']}"} for one in errors]
    if field is not None:
        evidence["field"] = f"problems.{k}.{field}"
    return type(fault)(f"problem {k}: {fault.detail}", evidence)
