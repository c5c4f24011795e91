"""Health, readiness, metrics, documentation."""

from pathlib import Path
from typing import Literal

import fastapi_offline
from fastapi import APIRouter, Request
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    PlainTextResponse,
    RedirectResponse,
)
from pydantic import Field

import planning
from service.api.dependencies import JobsDep
from service.api.metrics import MEDIA_TYPE, Metrics
from service.api.models import ResponseModel
from service.api.responses import problems
from service.api.routing.strict_route import StrictRoute
from service.versions import versions


class Health(ResponseModel):
    """Sign that the server is there."""

    status: Literal["ok"] = Field(
        description="Always `ok`; a server that is not there does not answer"
    )
    version: str = Field(description="Version of Wayproof")
    kernel: str = Field(
        description="Instruction set of the native collision kernel; `none` where it was not "
        "built, and Drake answers everything, more slowly"
    )


class Readiness(ResponseModel):
    """Whether the server takes jobs."""

    status: Literal["ready"] = Field(description="Always `ready`; else the answer is 503")
    role: Literal["leader", "follower"] = Field(
        description="Role among the servers of its database: the leader runs the jobs of "
        "all; one server alone is the leader"
    )
    queued: dict[str, int] = Field(description="Jobs that wait, by queue")
    running: dict[str, int] = Field(description="Jobs that run, by queue")


router = APIRouter(route_class=StrictRoute, tags=["operations"])

_ASSETS = Path(fastapi_offline.__file__).parent / "static"
# The page is Swagger UI, whose parts come from this server: browsers ask no other one.
_POLICY = (
    "default-src 'none'; connect-src 'self'; img-src 'self' data:; font-src 'self' data:; "
    "script-src 'self' 'unsafe-inline'; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_SETTINGS = {
    "validatorUrl": None,
    "docExpansion": "list",
    "defaultModelsExpandDepth": 0,
    "filter": True,
    "tryItOutEnabled": True,
}
type Asset = Literal["swagger-ui-bundle.js", "swagger-ui.css", "favicon.png"]
_METRICS = {"content": {"text/plain": {"schema": {"type": "string"}}}}


@router.get("/healthz", operation_id="getHealth", responses=problems(422))
async def get_health() -> Health:
    """Say that the server is there."""
    return Health(status="ok", version=versions()["wayproof"], kernel=planning.kernel_name())


@router.get("/readyz", operation_id="getReadiness", responses=problems(422, 503))
async def get_readiness(jobs: JobsDep) -> Readiness:
    """Say whether jobs begin at once: the database answers, and workers have planned a motion."""
    jobs.check_ready()
    counts = await jobs.counts()
    return Readiness(
        status="ready", role=jobs.role, queued=counts["queued"], running=counts["running"]
    )


@router.get(
    "/metrics",
    operation_id="getMetrics",
    response_class=PlainTextResponse,
    responses={200: _METRICS, **problems(422, 503)},
)
async def get_metrics(request: Request, jobs: JobsDep) -> PlainTextResponse:
    """Count jobs, requests, stages, what waits, workers and failures, as Prometheus reads it."""
    metrics: Metrics = request.app.state.metrics
    metrics.note_role(jobs.role)
    text = metrics.exposition(await jobs.counts(), jobs.loads())
    return PlainTextResponse(text, media_type=MEDIA_TYPE)


@router.get("/", include_in_schema=False)
def get_root() -> RedirectResponse:
    """Lead who opens the server's address to its documentation."""
    return RedirectResponse("docs")


@router.get("/openapi.json", include_in_schema=False)
def get_description(request: Request) -> JSONResponse:
    """Describe all of this."""
    return JSONResponse(request.app.openapi())


@router.get("/docs", include_in_schema=False)
async def get_docs() -> HTMLResponse:
    """Show the documentation; the page needs no network but this server."""
    page = get_swagger_ui_html(
        openapi_url="openapi.json",
        title="Wayproof: the HTTP API",
        swagger_js_url="docs/swagger-ui-bundle.js",
        swagger_css_url="docs/swagger-ui.css",
        swagger_favicon_url="docs/favicon.png",
        swagger_ui_parameters=_SETTINGS,
    )
    page.headers["Content-Security-Policy"] = _POLICY
    return page


@router.get("/docs/{asset}", include_in_schema=False)
async def get_docs_asset(asset: Asset) -> FileResponse:
    """Serve a part of the documentation."""
    return FileResponse(_ASSETS / asset, headers={"Cache-Control": "max-age=86400"})
