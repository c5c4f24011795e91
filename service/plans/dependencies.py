"""The plan that an endpoint's path names, as much of it as is needed."""

from typing import Annotated

from fastapi import Depends

from service.api.dependencies import JobsDep
from service.api.params import PlanId
from service.jobs.job import Job, JobSummary, JobText
from service.plans.plan_job import read_plan


async def _plan_job(plan: PlanId, jobs: JobsDep) -> Job:
    return await read_plan(jobs, plan)


async def _plan_text(plan: PlanId, jobs: JobsDep) -> JobText:
    return await jobs.job_text("plan", plan)


async def _open_plan(plan: PlanId, jobs: JobsDep) -> JobSummary:
    return await jobs.open_job("plan", plan)


# Without the samples of its motion.
type PlanJob = Annotated[Job, Depends(_plan_job)]
# With its result, which is passed on as it is.
type PlanText = Annotated[JobText, Depends(_plan_text)]
# As memory has it while it waits or runs: what is to be stopped waits for no database.
type OpenPlan = Annotated[JobSummary, Depends(_open_plan)]
