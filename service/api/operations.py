"""Health, readiness, metrics, documentation."""

from pathlib import Path

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, JSONResponse, PlainTextResponse, RedirectResponse

import planning
from service.api.metrics import exposition
from service.api.operations_models import Health, Readiness
from service.api.responses import problems
from service.dependencies import JobsDep, ScenesDep
from service.versions import versions

router = APIRouter(tags=["operations"])

_DOCS = Path(__file__).parent / "pages" / "docs.html"
_METRICS = {"content": {"text/plain": {"schema": {"type": "string"}}}}


@router.get("/healthz", operation_id="getHealth", responses=problems(422))
async def get_health() -> Health:
    """Say that the server is there."""
    return Health(status="ok", version=versions()["wayproof"], kernel=planning.kernel_name())


@router.get("/readyz", operation_id="getReadiness", responses=problems(422, 503))
async def get_readiness(desk: JobsDep, scenes: ScenesDep) -> Readiness:
    """Say whether jobs begin at once: the database answers, and workers have planned a motion."""
    desk.check_ready()
    await scenes.page(1, None)
    counts = await desk.counts()
    return Readiness(status="ready", queued=counts["queued"], running=counts["running"])


@router.get(
    "/metrics",
    operation_id="getMetrics",
    response_class=PlainTextResponse,
    responses={200: _METRICS, **problems(422, 503)},
)
async def get_metrics(desk: JobsDep) -> PlainTextResponse:
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
