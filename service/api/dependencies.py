"""What endpoints are handed: settings and jobs, which live in the app's state.

It is asynchronous: FastAPI has a thread carry out what is not, which takes longer than that. To be
handed something takes some time too: what needs several of these takes them from the request.
"""

from typing import Annotated

from fastapi import Depends, Request
from starlette.types import Scope

from service.jobs.service import JobService
from service.settings import Settings

# Member of an ASGI scope: the name of the key of a request, where keys are needed.
CALLER = "wayproof.caller"
MAX_CLIENT = 80


def settings_of(request: Request) -> Settings:
    """Return the settings of the server that a request is sent to."""
    settings: Settings = request.app.state.settings
    return settings


def jobs_of(request: Request) -> JobService:
    """Return the jobs of the server, for the client that sends a request."""
    jobs: JobService = request.app.state.jobs
    return jobs.for_client(client_of(request.scope))


async def _settings(request: Request) -> Settings:
    return settings_of(request)


async def _jobs(request: Request) -> JobService:
    return jobs_of(request)


def client_of(scope: Scope) -> str:
    """Return who sends a request: the name of its key, or its address where there are no keys."""
    name = scope.get(CALLER)
    if name is not None:
        return f"key {name}"
    return f"address {(scope.get('client') or ('unknown',))[0]}"[:MAX_CLIENT]


type SettingsDep = Annotated[Settings, Depends(_settings)]
type JobsDep = Annotated[JobService, Depends(_jobs)]
