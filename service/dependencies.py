"""What endpoints are handed: settings, scenes, jobs; all of it lives in the app's state."""

from typing import Annotated

from fastapi import Depends, Request

from service.desk import Desk
from service.jobs.records import Job
from service.routes.answers import ExecutionId, PlanId, RegionsId
from service.scenes.shelf import SceneShelf
from service.settings import Settings


def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


def _scenes(request: Request) -> SceneShelf:
    scenes: SceneShelf = request.app.state.scenes
    return scenes


def _desk(request: Request) -> Desk:
    desk: Desk = request.app.state.desk
    return desk


type SettingsDep = Annotated[Settings, Depends(_settings)]
type ScenesDep = Annotated[SceneShelf, Depends(_scenes)]
type DeskDep = Annotated[Desk, Depends(_desk)]


async def _plan_job(plan: PlanId, desk: DeskDep) -> Job:
    return await desk.job("plan", plan)


async def _execution_job(execution: ExecutionId, desk: DeskDep) -> Job:
    return await desk.job("execution", execution)


async def _regions_job(regions: RegionsId, desk: DeskDep) -> Job:
    return await desk.job("regions", regions)


async def _open_plan(plan: PlanId, desk: DeskDep) -> Job:
    return await desk.open_job("plan", plan)


async def _open_execution(execution: ExecutionId, desk: DeskDep) -> Job:
    return await desk.open_job("execution", execution)


async def _open_regions(regions: RegionsId, desk: DeskDep) -> Job:
    return await desk.open_job("regions", regions)


type PlanJob = Annotated[Job, Depends(_plan_job)]
type ExecutionJob = Annotated[Job, Depends(_execution_job)]
type RegionsJobDep = Annotated[Job, Depends(_regions_job)]
# As memory has them while they wait or run: what is to be stopped waits for no database.
type OpenPlan = Annotated[Job, Depends(_open_plan)]
type OpenExecution = Annotated[Job, Depends(_open_execution)]
type OpenRegions = Annotated[Job, Depends(_open_regions)]
