"""The server process: uvicorn around the app."""

import logging
import os
import socket
import sys
import threading
from collections.abc import Callable
from typing import override

import uvicorn
from fastapi import FastAPI
from sqlalchemy.exc import SQLAlchemyError

from planning.errors import WayproofError
from service.app import create_app
from service.cli.connections import Connections, bounded_protocol, most_connections
from service.settings import Settings

# Streams of events would hold a stopping server without end [s].
_GRACE = 2
# What the process ends with when another server has its database.
TAKEN = 3


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

    app = create_app(settings, give_up)
    most = most_connections(settings.max_connections)
    config = uvicorn.Config(
        app,
        log_level=settings.log_level,
        log_config=None,  # its records go where all others go
        access_log=settings.log_level in {"debug", "info"},
        timeout_graceful_shutdown=_GRACE,
        loop="uvloop",
        http=bounded_protocol(Connections(most, settings.header_timeout)),
    )
    server = _Server(config, app, on_listening)
    if leashed:
        threading.Thread(target=_stop_with_stdin, args=(server,), daemon=True).start()
    server.run(sockets=[bound])
    if server.is_taken:
        raise SystemExit(TAKEN)


class _Server(uvicorn.Server):
    """Says when it listens, and why it cannot; brings robots to rest before clients have gone."""

    def __init__(
        self, config: uvicorn.Config, app: FastAPI, on_listening: Callable[[], None]
    ) -> None:
        super().__init__(config)
        self.is_taken = False
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
        self._app.state.is_stopping = True
        if hasattr(self._app.state, "jobs"):
            self._app.state.jobs.begin_to_stop()
        await super().shutdown(sockets)

    def give_up(self) -> None:
        """Stop, because another server has the database."""
        self.is_taken = self.should_exit = True

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


def _stop_with_stdin(server: uvicorn.Server) -> None:
    # Not by a buffered reader: an interpreter that ends cannot take its lock, and aborts.
    while os.read(sys.stdin.fileno(), 4096):
        pass
    server.should_exit = True
