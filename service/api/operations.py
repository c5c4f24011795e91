"""Health, readiness, metrics, documentation."""

from pathlib import Path
from typing import Literal

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, JSONResponse, PlainTextResponse, RedirectResponse
from pydantic import Field

import planning
from service.api.metrics import exposition
from service.api.models import ResponseModel
from service.api.responses import problems
from service.dependencies import DeskDep, ScenesDep
from service.versions import versions


class Health(ResponseModel):
    """That the server is there."""

    status: Literal["ok"] = Field(description="Always `ok`: no answer is the other answer")
    version: str = Field(description="Of Wayproof")
    kernel: str = Field(
        description="Instruction set of the native collision kernel; `none` where it was not "
        "built, and Drake answers everything, more slowly"
    )


class Readiness(ResponseModel):
    """Whether the server takes jobs."""

    status: Literal["ready"] = Field(description="Always `ready`; else the answer is 503")
    queued: dict[str, int] = Field(description="Jobs that wait, by lane")
    running: dict[str, int] = Field(description="Jobs that run, by lane")


router = APIRouter(tags=["operations"])

_DOCS = Path(__file__).parent / "pages" / "docs.html"
_METRICS = {"content": {"text/plain": {"schema": {"type": "string"}}}}


@router.get("/healthz", operation_id="getHealth", responses=problems(422))
async def get_health() -> Health:
    """Say that the server is there."""
    return Health(status="ok", version=versions()["wayproof"], kernel=planning.kernel_name())


@router.get("/readyz", operation_id="getReadiness", responses=problems(422, 503))
async def get_readiness(desk: DeskDep, scenes: ScenesDep) -> Readiness:
    """Say whether jobs begin at once: the database answers, and workers have planned a motion."""
    desk.require_ready()
    await scenes.page(1, None)
    counts = await desk.counts()
    return Readiness(status="ready", queued=counts["queued"], running=counts["running"])


@router.get(
    "/metrics",
    operation_id="getMetrics",
    response_class=PlainTextResponse,
    responses={200: _METRICS, **problems(422, 503)},
)
async def get_metrics(desk: DeskDep) -> PlainTextResponse:
    """Count jobs by lane and state, as Prometheus reads it."""
    text = exposition(await desk.counts())
    return PlainTextResponse(text, media_type="text/plain; version=0.0.4")


@router.get("/", include_in_schema=False)
def get_root() -> RedirectResponse:
    """Lead who opens the server's address to its documentation."""
    return RedirectResponse("docs")


@router.get("/openapi.json", include_in_schema=False)
def get_description(request: Request) -> JSONResponse:
    """Describe all of this."""
    return JSONResponse(request.app.openapi())


@router.get("/docs", include_in_schema=False)
def get_docs() -> HTMLResponse:
    """Show the documentation; the page needs no network but this server."""
    return HTMLResponse(_DOCS.read_text(encoding="utf-8"))
