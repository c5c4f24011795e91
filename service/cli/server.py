"""The server process: uvicorn around the app."""

import os
import socket
import sys
import threading
from typing import override

import uvicorn
from fastapi import FastAPI

from service.app import create_app
from service.settings import Settings

# Streams of events would hold a stopping server without end [s].
_GRACE = 2
# What the process ends with when another server has its database.
TAKEN = 3


class _Server(uvicorn.Server):
    """Brings robots to rest as soon as it is told to stop, not when its clients have gone."""

    def __init__(self, config: uvicorn.Config, app: FastAPI) -> None:
        """Serve `app`."""
        super().__init__(config)
        self.is_taken = False
        self._app = app

    @override
    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        if hasattr(self._app.state, "desk"):
            self._app.state.desk.begin_to_stop()
        await super().shutdown(sockets)

    def give_up(self) -> None:
        """Stop, because another server has the database."""
        self.is_taken = self.should_exit = True


def run(settings: Settings, bound: socket.socket, *, log_level: str, leashed: bool) -> None:
    """Serve on a bound socket until told to stop.

    Args:
        settings: How the service runs.
        bound: Where it listens.
        log_level: Of uvicorn.
        leashed: Whether to stop when stdin closes, that is, when its parent is gone.

    Raises:
        SystemExit: Another server took the database over.
    """

    def give_up() -> None:
        server.give_up()

    app = create_app(settings, give_up)
    config = uvicorn.Config(app, log_level=log_level, timeout_graceful_shutdown=_GRACE)
    server = _Server(config, app)
    if leashed:
        threading.Thread(target=_stop_with_stdin, args=(server,), daemon=True).start()
    server.run(sockets=[bound])
    if server.is_taken:
        raise SystemExit(TAKEN)


def _stop_with_stdin(server: uvicorn.Server) -> None:
    # Not by a buffered reader: an interpreter that ends cannot take its lock, and aborts.
    while os.read(sys.stdin.fileno(), 4096):
        pass
    server.should_exit = True
