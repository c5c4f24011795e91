"""Regions jobs to the wire."""

from typing import Any

from service.jobs.records import Job
from service.plans.versions import versions

_FACES = ("regions", "portals")


def regions_brief(job: Job) -> dict[str, Any]:
    """Return regions without their faces."""
    done = job.result or {}
    result: dict[str, Any] | None = done.get("result")
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
        "versions": versions(),
        "timings": done.get("timings", {}),
        "summary": result and {name: result[name] for name in result if name not in _FACES},
    }


def regions_resource(job: Job) -> dict[str, Any]:
    """Return regions in full."""
    return {**regions_brief(job), "result": (job.result or {}).get("result")}
