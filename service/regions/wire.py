"""Regions jobs to the wire."""

from typing import Any

from service.jobs.job import JobSummary
from service.jobs.outline import outline_of, without
from service.jobs.service import JobService


def regions_brief(desk: JobService, job: JobSummary) -> dict[str, Any]:
    """Return regions without their faces."""
    done: dict[str, Any] = without(job.result or {}, outline_of(job.task).result)
    return {
        "id": job.id,
        "state": job.state,
        "stage": job.stage,
        "progress": 1.0 if job.state == "succeeded" else job.progress,
        "created_at": job.created_at,
        "started_at": job.started_at,
        "finished_at": job.finished_at,
        "scene": job.scene,
        "revision": job.payload["revision"],
        "request": job.payload["request"],
        "failure": job.failure,
        "versions": job.made_by or {},
        "timings": (done or job.failure or {}).get("timings") or {},
        "unrecorded": desk.unrecorded(job),
        "summary": done.get("result"),
    }
