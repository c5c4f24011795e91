"""What endpoints are handed: settings and jobs, which live in the app's state.

It is asynchronous: FastAPI has a thread carry out what is not, which takes longer than that.
"""

from typing import Annotated

from fastapi import Depends, Request

from service.jobs.service import JobService
from service.settings import Settings


async def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


async def _jobs(request: Request) -> JobService:
    jobs: JobService = request.app.state.jobs
    return jobs


type SettingsDep = Annotated[Settings, Depends(_settings)]
type JobsDep = Annotated[JobService, Depends(_jobs)]
