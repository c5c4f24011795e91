"""Plan jobs to the wire."""

from typing import Any

from service.errors import NotFinished
from service.jobs.job import Job, JobSummary
from service.jobs.outline import without
from service.jobs.tasks import outline_of
from service.plans.models.sampling import DEFAULT_PERIOD
from service.plans.models.trajectory_conversion import IN_QUERY, require_one_sampling
from service.scene_jobs import SceneJobs


def job_brief(desk: SceneJobs, job: JobSummary) -> dict[str, Any]:
    """Return a plan without its result; a graph is large and has an address of its own."""
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
        "failure": without(job.failure, outline_of(job.task).failure),
        "seed": request["seed"],
        "digest": done.get("digest"),
        "versions": job.made_by or {},
        "timings": timings_of(job),
        "unrecorded": desk.unrecorded(job),
    }


def timings_of(job: JobSummary) -> dict[str, float]:
    """Return the seconds per stage of a job that has ended, however it did."""
    ended: dict[str, Any] = job.result or job.failure or {}
    return dict(ended.get("timings") or {})


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


def motion_of(job: Job) -> dict[str, Any]:
    """Return what tasks need to sample the motion of a plan and to prove the samples.

    Raises:
        NotFinished: It has none (yet).
    """
    polynomial = polynomial_of(job)
    result = (job.result or {})["result"]
    return {
        **{part: job.payload[part] for part in ("scene", "library")},
        "trajectory": polynomial,
        # A way back was proven to keep what the way there was asked to.
        "request": job.payload.get("origin", job.payload["request"]),
        "parts": result.get("parts", []),
        "certificate": result["certificate"],
    }


def sampling_of(
    job: Job, period: float | None, num_points: int | None, *, even: bool
) -> dict[str, Any]:
    """Return at which instants to sample a plan: as asked for, or as it has it.

    Raises:
        ProblemInvalid: Both are asked for.
    """
    require_one_sampling(period, num_points, IN_QUERY)
    own = job.payload["request"]["retime"]
    if period is None and num_points is None:
        num_points = own.get("num_points")
        even = even or own.get("even_samples", False)
    return {
        "period": period or own["sample_period"] or DEFAULT_PERIOD,
        "num_points": num_points,
        "is_even": even,
    }


def graph_of(job: Job) -> dict[str, Any]:
    """Return what the planner of a plan explored.

    Raises:
        NotFinished: It has none: not yet, or nobody asked for it, or its planner tells none.
    """
    evidence = (job.failure or {}).get("evidence", {})
    graph: dict[str, Any] | None = (job.result or {}).get("graph") or evidence.get("graph")
    if graph is None:
        message = (
            f"plan {job.id} is {job.state} and has no graph; a search keeps one if its "
            "`keep_graph` is true and its planner tells it (AORRTC and BITstar do not)"
        )
        raise NotFinished(message, {"id": job.id, "state": job.state})
    return graph
