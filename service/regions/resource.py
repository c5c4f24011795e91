"""Regions as clients see them, from their jobs."""

from fastapi import Response

from service.api.failures.failure import Failure
from service.api.responses import whole
from service.jobs.job import JobSummary, JobText
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.regions.models import RegionsBrief
from service.regions.tasks import RegionsOutline, RegionsWork


def regions_brief(jobs: JobService, job: JobSummary) -> RegionsBrief:
    """Return regions without their faces."""
    job = jobs.with_cancel(job)
    work = RegionsWork.model_validate(job.payload)
    outcome = None if job.result is None else RegionsOutline.model_validate(job.result)
    failure = None if job.failure is None else Failure.model_validate(job.failure)
    ended = outcome or failure
    return RegionsBrief(
        id=job.id,
        state=JobState(job.state),
        stage=job.stage,
        progress=1.0 if job.state == "succeeded" else job.progress,
        created_at=job.created_at,
        started_at=job.started_at,
        finished_at=job.finished_at,
        cancel_requested_at=job.cancel_requested_at,
        attempts=job.attempts,
        scene=job.scene or "",
        revision=work.revision,
        request=work.request,
        failure=failure,
        versions=job.made_by or {},
        timings={} if ended is None else ended.timings,
        unrecorded=jobs.unrecorded(job),
        summary=None if outcome is None else outcome.result,
    )


async def regions_in_full(
    jobs: JobService, found: JobText, answer: Response | None = None
) -> Response:
    """Return regions with their faces, if they have grown, under the headers of an answer."""
    return await whole(regions_brief(jobs, found.summary), found.result, answer)
