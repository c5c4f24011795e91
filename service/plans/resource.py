"""Plans as their jobs have them: what clients are shown, and the motion that was delivered."""

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, SkipValidation

from planning.domain.report.motion_plan import PlanPart
from service.errors import NotFinished
from service.jobs.job import Job, JobSummary
from service.jobs.outline import without
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.jobs.task import TaskModel, outline_of
from service.plans.models.plan import PlanSummary
from service.plans.models.request import PlanRequest
from service.plans.models.search_reports import PlannerGraph
from service.plans.models.trajectory import Polynomial
from service.plans.tasks import (
    DeliveredWork,
    FailureWork,
    MotionWork,
    PictureWork,
    PlotWork,
)


def _trusted(stored: dict[str, Any]) -> Polynomial:
    return Polynomial.model_construct(**stored)


def _ends(rows: list[list[float]]) -> list[list[float]]:
    return [rows[0], rows[-1]]


# What workers have written may be megabytes, and is not validated again.
type _Rows = SkipValidation[list[list[float]]]


class ProvenClearance(TaskModel):
    """What a stored certificate says of clearance."""

    min_clearance: float | None
    observed_clearance: float | None = None

    @property
    def proven_clearance(self) -> float:
        """What no distance is below [m]."""
        # Older versions stored the smallest distance that was seen: nothing is known to be proven.
        if "observed_clearance" not in self.model_fields_set:
            return -math.inf
        return math.inf if self.min_clearance is None else self.min_clearance


class Ends(TaskModel):
    """The first and the last sample of a motion."""

    positions: Annotated[_Rows, BeforeValidator(_ends)]


class DeliveredResult(TaskModel):
    """What is needed of a `PlanResult`."""

    start: list[float]
    path: _Rows
    parts: tuple[PlanPart, ...] = ()
    trajectory: Ends
    certificate: ProvenClearance


class DeliveredMotion(TaskModel):
    """What is needed of a `PlanOutcome` to use its motion."""

    polynomial: Annotated[Polynomial, BeforeValidator(_trusted)]
    result: DeliveredResult


async def plan_resource(
    jobs: JobService, job: JobSummary, request: PlanRequest | None = None
) -> PlanSummary:
    """Return a plan without its result; a graph is large and has an address of its own.

    Args:
        jobs: Where it is.
        job: That plans.
        request: Of the job, if it has been read already.
    """
    job = jobs.with_cancel(job)
    outcome = job.result or {}
    is_running = job.state is JobState.RUNNING
    best = await jobs.latest_event(job, "best-so-far") if is_running else None
    return PlanSummary.model_validate({
        "id": job.id,
        "batch": job.batch,
        "state": job.state,
        "stage": job.stage,
        "progress": 1.0 if job.state == "succeeded" else job.progress,
        "best": best if best and "length" in best else None,
        "created_at": job.created_at,
        "started_at": job.started_at,
        "finished_at": job.finished_at,
        "cancel_requested_at": job.cancel_requested_at,
        "attempts": job.attempts,
        "request": request or job.payload["request"],
        "failure": without(job.failure, outline_of(job.task).failure),
        "seed": job.payload["request"]["seed"],
        "digest": outcome.get("digest"),
        "versions": job.made_by or {},
        # However it ended.
        "timings": (job.result or job.failure or {}).get("timings") or {},
        "unrecorded": jobs.unrecorded(job),
    })


def work_of(job: JobSummary) -> MotionWork:
    """Return what a plan was made from."""
    return MotionWork.model_validate(job.payload)


def motion_of(job: Job) -> DeliveredMotion:
    """Return the motion of a plan.

    Raises:
        NotFinished: It has none (yet).
    """
    if job.state != "succeeded" or job.result is None:
        evidence = {"id": job.id, "state": job.state, "failure": job.failure}
        raise NotFinished(f"plan {job.id} is {job.state}: it has no trajectory", evidence)
    return DeliveredMotion.model_validate(job.result)


def delivered_work(job: Job) -> DeliveredWork:
    """Return the motion of a plan in its scene; raises as `motion_of`."""
    work, trajectory = work_of(job), motion_of(job).polynomial
    return DeliveredWork(
        library=work.library, scene=work.scene, group=work.request.group, trajectory=trajectory
    )


def plot_work(job: Job, *names: str) -> PlotWork:
    """Return the motion of a plan and the charts to draw of it; raises as `motion_of`."""
    request = work_of(job).request
    delivered = dict(delivered_work(job))
    return PlotWork(**delivered, names=names, retime=request.retime, margin=request.margin)


def picture_work(job: Job) -> PictureWork:
    """Return the motion of a plan, and where it is narrowest; raises as `motion_of`."""
    certificate = ((job.result or {}).get("result") or {}).get("certificate") or {}
    pair = [name for name in certificate.get("pair") or () if name]
    return PictureWork(
        **dict(delivered_work(job)),
        nearest_at=certificate.get("time") if pair else None,
        pair=pair,
        points=certificate.get("points") or [],
    )


def failure_work(job: Job) -> FailureWork:
    """Return the failure of a plan in its scene.

    Raises:
        NotFinished: It has not failed.
    """
    if job.failure is None:
        evidence = {"id": job.id, "state": job.state, "failure": None}
        raise NotFinished(f"plan {job.id} is {job.state}: it has no failure", evidence)
    work, failure = work_of(job), without(job.failure, outline_of(job.task).failure)
    return FailureWork(
        library=work.library,
        scene=work.scene,
        plan=job.id,
        request=work.request,
        failure=failure or {},
    )


def graph_of(job: Job) -> PlannerGraph:
    """Return what the planner of a plan explored.

    Raises:
        NotFinished: There is no graph: not yet, or none was kept, or its planner has none.
    """
    evidence = (job.failure or {}).get("evidence", {})
    graph: dict[str, Any] | None = (job.result or {}).get("graph") or evidence.get("graph")
    if graph is None:
        message = (
            f"plan {job.id} is {job.state} and has no graph; a search keeps one if its "
            "`keep_graph` is true and its planner tells it (AORRTC and BITstar do not)"
        )
        raise NotFinished(message, {"id": job.id, "state": job.state})
    return PlannerGraph.model_validate(graph)
