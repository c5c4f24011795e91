"""The server process: uvicorn around the app."""

import asyncio
import logging
import os
import socket
import sys
import threading
from collections.abc import Callable
from types import FrameType
from typing import override

import uvicorn
from fastapi import FastAPI
from sqlalchemy.exc import SQLAlchemyError

from planning import bundled_folder
from planning.errors import WayproofError
from service.app import create_app
from service.cli.connections import (
    MAX_MESSAGE_BYTES,
    Connections,
    bounded_protocol,
    bounded_socket,
    most_connections,
)
from service.jobs.service import JobService
from service.settings import Settings
from service.studio import front
from service.studio.process import StudioProcess
from service.telemetry.traces import TracingUnavailable, start_tracing, stop_tracing
from service.versions import versions

# Streams of events would hold a stopping server without end [s].
_GRACE = 2
# Between looks at whether what runs has ended [s].
_PERIOD = 0.05
# What the process ends with when another server has its database.
TAKEN = 3
_log = logging.getLogger(__name__)


class CannotStart(Exception):
    """The server cannot start, for a reason that its operator can change."""


def run(
    settings: Settings,
    bound: socket.socket,
    *,
    leashed: bool,
    on_listening: Callable[[], None],
) -> None:
    """Serve on a bound socket until told to stop.

    Args:
        settings: How the service runs.
        bound: Where it listens.
        leashed: Whether to stop when stdin closes, that is, when what started it is gone.
        on_listening: Called once it takes requests.

    Raises:
        CannotStart: The data folder, the database or the address is not to be had.
        SystemExit: Another server took the database over.
    """

    def give_up() -> None:
        server.give_up()

    if settings.otlp_endpoint is not None:
        try:
            start_tracing(settings.otlp_endpoint, versions()["wayproof"])
        except TracingUnavailable as fault:
            raise CannotStart(str(fault)) from fault
    app = create_app(settings, give_up)
    if settings.studio and front.is_available():
        studio = StudioProcess(asked_at(bound), bundled_folder("scenes"))
        front.install(app, studio.upstream, is_server=True)
    most = most_connections(settings.max_connections)
    connections = Connections(most, settings.header_timeout)
    config = uvicorn.Config(
        app,
        log_level=settings.log_level,
        log_config=None,  # its records go where all others go
        access_log=settings.log_level in {"debug", "info"},
        timeout_graceful_shutdown=_GRACE,
        loop="uvloop",
        http=bounded_protocol(connections),
        ws=bounded_socket(connections),
        ws_max_size=MAX_MESSAGE_BYTES,
    )
    server = _Server(config, app, on_listening)
    if leashed:
        threading.Thread(target=_stop_with_stdin, args=(server,), daemon=True).start()
    try:
        server.run(sockets=[bound])
    finally:
        stop_tracing()
    if server.is_taken:
        raise SystemExit(TAKEN)


class _Server(uvicorn.Server):
    """Says when it listens, and why it cannot; brings robots to rest before clients have gone."""

    def __init__(
        self, config: uvicorn.Config, app: FastAPI, on_listening: Callable[[], None]
    ) -> None:
        super().__init__(config)
        self.is_taken = False
        self._is_hurried = False
        self._app = app
        self._on_listening = on_listening

    @override
    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        log = logging.getLogger("uvicorn.error")
        log.addFilter(self._is_news)
        begin = self.lifespan.startup

        async def begin_and_listen() -> None:
            # Not left to uvloop, which never closes a loop in which listening has failed.
            await begin()
            for bound in () if self.lifespan.should_exit else sockets or ():
                bound.listen(self.config.backlog)

        self.lifespan.startup = begin_and_listen
        try:
            await super().startup(sockets)
        except SystemExit as ended:  # of the app's lifespan, whose fault it keeps
            raise self._reason() or ended from None
        except OSError as fault:
            await self.lifespan.shutdown()
            message = f"cannot listen: {fault.strerror or fault}"
            raise CannotStart(message) from fault
        finally:
            log.removeFilter(self._is_news)
        self._on_listening()

    @override
    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        jobs: JobService | None = getattr(self._app.state, "jobs", None)
        if jobs is not None:
            await self._drain(jobs)
        self._app.state.is_stopping = True
        if jobs is not None:
            jobs.begin_to_stop()
        await super().shutdown(sockets)

    @override
    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to stop; at the second signal, wait for no plan.

        Uvicorn's way with a second one leaves robots and records as they are: it is not taken.
        """
        if self.should_exit:
            self._is_hurried = True
        else:
            super().handle_exit(sig, frame)

    def stop_now(self) -> None:
        """Stop, and wait for no plan; may be called in any thread."""
        self._is_hurried = self.should_exit = True

    def give_up(self) -> None:
        """Stop, because another server has the database."""
        self.is_taken = True
        self.stop_now()

    async def _drain(self, jobs: JobService) -> None:
        """Let what runs end by itself for a while; everything but a new job is answered."""
        seconds, now = self._app.state.settings.drain_seconds, asyncio.get_running_loop().time
        _log.info("the server is told to end: what runs has %g s to end by itself", seconds)
        until = now() + seconds
        drained = asyncio.ensure_future(jobs.drain())
        while not (drained.done() or self._is_hurried or now() >= until):
            await asyncio.wait({drained}, timeout=_PERIOD)
        drained.cancel()
        await asyncio.gather(drained, return_exceptions=True)

    def _is_news(self, _: logging.LogRecord) -> bool:
        """Uvicorn logs the whole traceback of a fault that takes one sentence."""
        return self._reason() is None

    def _reason(self) -> CannotStart | None:
        fault: BaseException | None = getattr(self._app.state, "start_fault", None)
        match fault:
            case WayproofError():
                return CannotStart(fault.detail)
            case OSError():
                name = fault.filename or "the data folder"
                return CannotStart(f"cannot use {name}: {fault.strerror or fault}")
            case SQLAlchemyError():
                reason = str(getattr(fault, "orig", None) or fault).splitlines()[0]
                return CannotStart(f"cannot use the database: {reason}")
            case _:
                return None


def _stop_with_stdin(server: _Server) -> None:
    # Not by a buffered reader: an interpreter that ends cannot take its lock, and aborts.
    while os.read(sys.stdin.fileno(), 4096):
        pass
    server.stop_now()  # what started it does not wait for plans


def asked_at(bound: socket.socket) -> str:
    """Return the URL at which this machine asks a server that is bound to a socket."""
    host, port = bound.getsockname()[:2]
    any_address = {"0.0.0.0": "127.0.0.1", "::": "::1"}  # noqa: S104
    near: str = any_address.get(str(host), str(host))
    return f"http://[{near}]:{port}" if ":" in near else f"http://{near}:{port}"
