"""create_app(): the service, put together."""

from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager, nullcontext
from functools import partial

from fastapi import FastAPI

from service.api import error_responses as problems
from service.api import operations
from service.api.document import openapi
from service.api.metrics import MeasureRequests, Metrics
from service.api.middleware.body_limit import BodyLimit
from service.api.middleware.client_disconnect import DisconnectWatch
from service.api.middleware.graceful_shutdown import GracefulShutdown
from service.api.middleware.host_check import HostCheck
from service.api.middleware.request_id import RequestId
from service.api.middleware.response_headers import ResponseHeaders
from service.api.routing.exact_paths import ExactPaths
from service.catalog import routes as catalog
from service.executions import replay
from service.executions import routes as executions
from service.lifespan import open_services
from service.live import routes as live
from service.live import socket as live_socket
from service.live.feed import LiveFeeds
from service.plans import batch_routes as batches
from service.plans import routes as plans
from service.plans.bundle import routes as bundles
from service.plans.delivery import page_routes as pages
from service.plans.delivery import routes as outputs
from service.queries import geometry_routes as geometry
from service.queries import routes as queries
from service.queries import view_routes as views
from service.regions import routes as regions
from service.scenes import routes as scenes
from service.security.audit import Audit
from service.security.callers import open_callers
from service.security.cross_origin import allow_origins
from service.security.document import declare_security
from service.security.guard import Guard
from service.security.start import require_guarded
from service.settings import Settings
from service.telemetry.traces import request_telemetry
from service.trajectories import routes as trajectories
from service.versions import versions
from service.webhooks import routes as webhooks

_DESCRIPTION = (
    "Plans robot motion and proves it. SI units, radians, quaternions as `[w, x, y, z]`. Unknown "
    "fields, unknown query parameters, keys given twice and non-finite numbers are refused. Bodies "
    "are `application/json`, of at most 4 MiB; scenes may have 32 MiB, or be YAML of 2 MB. Errors "
    "are `application/problem+json` (RFC 9457). Every answer has `X-Request-ID`: that of the "
    "request, if it is 1 to 64 of `A-Z a-z 0-9 . _ -`, else a new one."
)
# What has routes of its own, in the order of the OpenAPI document.
PARTS = (
    scenes,
    geometry,
    views,
    queries,
    regions,
    catalog,
    batches,
    plans,
    outputs,
    pages,
    bundles,
    trajectories,
    executions,
    replay,
    live,
    webhooks,
    operations,
)


def _nothing() -> None:
    pass


def create_app(
    settings: Settings | None = None, on_taken: Callable[[], None] = _nothing
) -> FastAPI:
    """Return the service; its workers run between startup and shutdown.

    Args:
        settings: How it runs; None to read them from the environment.
        on_taken: Called when another server has taken the database over: this one is of no use.
    """
    chosen = settings or Settings()

    metrics = Metrics()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[None]:
        app.state.start_fault = None
        has_started = False
        try:
            require_guarded(chosen)
            async with (
                open_services(chosen, on_taken, metrics) as services,
                open_callers(chosen) if chosen.auth == "keys" else nullcontext() as callers,
            ):
                app.state.jobs, app.state.scenes, app.state.webhooks = services
                app.state.callers = callers
                app.state.feeds = LiveFeeds(app.state.scenes, app.state.jobs)
                has_started = True
                yield
        except Exception as fault:
            if not has_started:
                app.state.start_fault = fault  # what runs the app says it in a sentence
            raise

    app = FastAPI(
        title="Wayproof",
        version=versions()["wayproof"],
        description=_DESCRIPTION,
        lifespan=lifespan,
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        telemetry=request_telemetry(),
    )
    app.state.settings = chosen
    app.state.metrics = metrics
    app.add_middleware(DisconnectWatch)
    app.add_middleware(
        BodyLimit, max_scene_bytes=chosen.max_body_bytes, allowed=chosen.body_timeout
    )
    app.add_middleware(Guard, settings=chosen, callers=lambda: app.state.callers)
    app.add_middleware(Audit)
    allow_origins(app, chosen.allowed_origins)
    app.add_middleware(HostCheck, settings=chosen)
    app.state.is_stopping = False
    app.add_middleware(GracefulShutdown, is_stopping=lambda: app.state.is_stopping)
    app.add_middleware(ResponseHeaders)
    app.add_middleware(MeasureRequests, metrics=metrics)
    app.add_middleware(RequestId)
    problems.install(app)
    openapi.install(app, partial(declare_security, is_asked=chosen.auth == "keys"))
    # Not by `include_router`, which makes each route once more, and looks each request up twice.
    for router in (*(part.router for part in PARTS), live_socket.router):
        app.router.routes.extend(router.routes)
    app.router.middleware_stack = ExactPaths(app.router)
    return app
