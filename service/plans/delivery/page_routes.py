"""/v1/plans/{id}/failure.html, report.html: pages that need nothing else, to pass on."""

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from planning.errors import DeadlineExceeded
from service.api.dependencies import JobsDep
from service.api.responses import HTML_PAGE, problems
from service.api.routing.strict_route import StrictRoute
from service.errors import NotFinished
from service.jobs.job import Job
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.plans.delivery.report import CHARTS, report_html
from service.plans.dependencies import PlanJob
from service.plans.resource import failure_work, picture_work, plan_resource, plot_work
from service.plans.tasks import (
    NO_PICTURES,
    PICTURES,
    PLOT_ALL,
    SHOW_FAILURE,
    MotionPictures,
)

router = APIRouter(route_class=StrictRoute, prefix="/v1/plans/{plan}", tags=["plans"])


@router.get(
    "/failure.html",
    operation_id="getFailureView",
    response_class=HTMLResponse,
    responses={200: HTML_PAGE, **problems(404, 409, 422, 429, 503)},
)
async def get_failure(job: PlanJob, jobs: JobsDep) -> HTMLResponse:
    """Show in 3-D where a plan failed: the configuration, the bodies that meet in red, and why."""
    page = await jobs.call(SHOW_FAILURE, failure_work(job))
    return HTMLResponse(page.html)


@router.get(
    "/report.html",
    operation_id="getPlanReport",
    response_class=HTMLResponse,
    responses={200: HTML_PAGE, **problems(404, 409, 422, 429, 503)},
)
async def get_report(job: PlanJob, jobs: JobsDep) -> HTMLResponse:
    """Report on a plan that has ended: request, certificate, pictures, charts; for printing."""
    if not job.state.is_final:
        evidence = {"id": job.id, "state": job.state, "failure": None}
        raise NotFinished(f"plan {job.id} is {job.state}: there is nothing to report", evidence)
    charts: dict[str, str] = {}
    pictures: MotionPictures | None = NO_PICTURES
    if job.state is JobState.SUCCEEDED:
        charts = (await jobs.call(PLOT_ALL, plot_work(job, *CHARTS))).svg
        pictures = await _pictures(jobs, job)
    result = (job.result or {}).get("result") or {}
    return HTMLResponse(report_html(await plan_resource(jobs, job), result, charts, pictures))


async def _pictures(jobs: JobService, job: Job) -> MotionPictures | None:
    """Draw the motion; None if that takes longer than a question may: the rest is worth having."""
    try:
        return await jobs.call(PICTURES, picture_work(job))
    except DeadlineExceeded:
        return None
