"""The server process: uvicorn around the app."""

import socket
import sys
import threading

import uvicorn

from service.app import create_app
from service.settings import Settings

# Streams of events would hold a stopping server for ever.
_GRACE = 2


def run(settings: Settings, bound: socket.socket, *, log_level: str, leashed: bool) -> None:
    """Serve on a bound socket until told to stop.

    Args:
        settings: How the service runs.
        bound: Where it listens.
        log_level: Of uvicorn.
        leashed: Whether to stop when stdin closes, that is, when whoever started it is gone.
    """
    config = uvicorn.Config(
        create_app(settings), log_level=log_level, timeout_graceful_shutdown=_GRACE
    )
    server = uvicorn.Server(config)
    if leashed:
        threading.Thread(target=_stop_with_stdin, args=(server,), daemon=True).start()
    server.run(sockets=[bound])


def _stop_with_stdin(server: uvicorn.Server) -> None:
    sys.stdin.buffer.read()
    server.should_exit = True
