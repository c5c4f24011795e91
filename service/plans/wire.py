"""Plan jobs to the wire."""

from typing import Any

from service.errors import NotFinished
from service.jobs.records import Job
from service.plans.versions import versions


def job_brief(job: Job) -> dict[str, Any]:
    """Return a plan without its result."""
    request = job.payload["request"]
    done = job.result or {}
    return {
        "id": job.id,
        "state": job.state,
        "stage": job.stage,
        "progress": 1.0 if job.state == "succeeded" else job.progress,
        "created_at": job.created_at,
        "started_at": job.started_at,
        "finished_at": job.finished_at,
        "request": request,
        "failure": job.failure,
        "seed": request["seed"],
        "digest": done.get("digest"),
        "versions": versions(),
        "timings": done.get("timings", {}),
    }


def job_resource(job: Job) -> dict[str, Any]:
    """Return a plan in full."""
    return {**job_brief(job), "result": (job.result or {}).get("result")}


def polynomial_of(job: Job) -> dict[str, Any]:
    """Return the exact trajectory of a plan.

    Raises:
        NotFinished: It has none (yet).
    """
    if job.state != "succeeded" or job.result is None:
        evidence = {"id": job.id, "state": job.state, "failure": job.failure}
        raise NotFinished(f"plan {job.id} is {job.state}: it has no trajectory", evidence)
    polynomial: dict[str, Any] = job.result["polynomial"]
    return polynomial
