"""What endpoints are handed: settings, scenes, jobs; all of it lives in the app's state.

All of it is asynchronous: FastAPI has a thread carry out what is not, which takes longer than that.
"""

from typing import Annotated

from fastapi import Depends, Request

from service.api.params import ExecutionId, PlanId, RegionsId
from service.jobs.job import Job, JobSummary, JobText
from service.scene_jobs import SceneJobs
from service.scenes.store import SceneStore
from service.settings import Settings


async def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


async def _scenes(request: Request) -> SceneStore:
    scenes: SceneStore = request.app.state.scenes
    return scenes


async def _jobs(request: Request) -> SceneJobs:
    jobs: SceneJobs = request.app.state.jobs
    return jobs


type SettingsDep = Annotated[Settings, Depends(_settings)]
type ScenesDep = Annotated[SceneStore, Depends(_scenes)]
type JobsDep = Annotated[SceneJobs, Depends(_jobs)]


async def _plan_job(plan: PlanId, jobs: JobsDep) -> Job:
    return await jobs.job("plan", plan)


async def _plan_text(plan: PlanId, jobs: JobsDep) -> JobText:
    return await jobs.job_text("plan", plan)


async def _execution_job(execution: ExecutionId, jobs: JobsDep) -> Job:
    return await jobs.job("execution", execution)


async def _regions_text(regions: RegionsId, jobs: JobsDep) -> JobText:
    return await jobs.job_text("regions", regions)


async def _open_plan(plan: PlanId, jobs: JobsDep) -> JobSummary:
    return await jobs.open_job("plan", plan)


async def _open_execution(execution: ExecutionId, jobs: JobsDep) -> JobSummary:
    return await jobs.open_job("execution", execution)


async def _open_regions(regions: RegionsId, jobs: JobsDep) -> JobSummary:
    return await jobs.open_job("regions", regions)


type PlanJob = Annotated[Job, Depends(_plan_job)]
type ExecutionJob = Annotated[Job, Depends(_execution_job)]
# With results that are passed on as they are.
type PlanText = Annotated[JobText, Depends(_plan_text)]
type RegionsText = Annotated[JobText, Depends(_regions_text)]
# As memory has them while they wait or run: what is to be stopped waits for no database.
type OpenPlan = Annotated[JobSummary, Depends(_open_plan)]
type OpenExecution = Annotated[JobSummary, Depends(_open_execution)]
type OpenRegions = Annotated[JobSummary, Depends(_open_regions)]
