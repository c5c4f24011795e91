"""Execution jobs to the wire."""

from typing import Any

from service.executions.position import last_status
from service.jobs.job import JobSummary
from service.scene_jobs import SceneJobs

_FINAL = {"succeeded": "succeeded", "failed": "aborted", "canceled": "canceled"}


async def execution_resource(desk: SceneJobs, job: JobSummary) -> dict[str, Any]:
    """Return an execution in full."""
    status = await last_status(desk, job)
    state = state_of(job, status)
    return {
        "id": job.id,
        "state": state,
        "created_at": job.created_at,
        "started_at": job.started_at,
        "finished_at": job.finished_at,
        "request": job.payload["request"],
        "scene": job.payload["scene_id"],
        "group": job.payload["group"],
        "status": None if status is None else {**status, "state": state},
        "failure": job.failure,
        "unrecorded": desk.unrecorded(job),
    }


def state_of(job: JobSummary, status: dict[str, Any] | None) -> str:
    """Return the state of an execution: the job's where that is final, else what it told last."""
    if job.state in _FINAL:
        return _FINAL[job.state]
    if job.is_cancel_requested:
        return "canceling"
    if job.state == "queued":
        return "accepted"
    told = "executing" if status is None else str(status["state"])
    return "executing" if told in _FINAL.values() else told
