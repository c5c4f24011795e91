"""Connections: how many there are, and how long and how large the headers of a request may be.

Uvicorn waits without end for the rest of a request's headers, keeps all of them in memory, and
takes connections until the process has no more files: a few hundred half-sent requests then deafen
it.
"""

import asyncio
import resource
from typing import Any, cast, override

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.websockets.wsproto_impl import WSProtocol

# Files that are no connections: the database, workers' sockets, the log.
_OTHER_FILES = 128
# Of headers that have not ended; what comes in one piece with their end is not counted.
_MAX_HEADER_BYTES = 64 * 2**10
# Of a WebSocket's client: a browser of the studio says where a slider is, and uploads nothing.
MAX_MESSAGE_BYTES = 2**20
_LATE = b"HTTP/1.1 408 Request Timeout\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
_LARGE = (
    b"HTTP/1.1 431 Request Header Fields Too Large\r\nContent-Length: 0\r\n"
    b"Connection: close\r\n\r\n"
)
_FULL = (
    b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nRetry-After: 1\r\n"
    b"Connection: close\r\n\r\n"
)


class Connections:
    """The connections of one server, those that say nothing in the order in which they began to."""

    def __init__(self, most: int, header_timeout: float) -> None:
        """Allow `most` at once, and each `header_timeout` [s] for the headers of a request."""
        self.header_timeout = header_timeout
        self._most = most
        self._all: set[Any] = set()
        self._silent: dict[Any, None] = {}

    def add(self, connection: Any) -> bool:
        """Take a connection in, in the place of the one that is silent for longest if need be.

        Returns:
            Whether there is room for it.
        """
        while len(self._all) >= self._most and self._silent:
            oldest = next(iter(self._silent))
            self.remove(oldest)
            oldest.transport.abort()
        if len(self._all) >= self._most:
            return False
        self._all.add(connection)
        self._silent[connection] = None
        return True

    def remove(self, connection: Any) -> None:
        """Forget a connection."""
        self._all.discard(connection)
        self._silent.pop(connection, None)

    def mark(self, connection: Any, *, silent: bool) -> None:
        """Note whether a connection has asked for something that is being answered."""
        if not silent:
            self._silent.pop(connection, None)
        elif connection in self._all:
            self._silent[connection] = None


def most_connections(wanted: int) -> int:
    """Return how many connections there can be: as many as wanted, if there are files for them."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    needed = wanted + _OTHER_FILES
    if soft < needed:
        soft = min(needed, hard)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return max(1, min(wanted, soft - _OTHER_FILES))


class _Bounded:
    """What uvicorn's protocols lack, to be mixed into one of them."""

    bounds: Connections
    loop: asyncio.AbstractEventLoop
    transport: asyncio.Transport
    cycle: Any
    _timer: asyncio.TimerHandle | None = None
    _in_headers = False
    _is_handed_on = False
    _num_header_bytes = 0

    def connection_made(self, transport: Any) -> None:
        cast("Any", super()).connection_made(transport)
        if self.bounds.add(self):
            self._begin()
        else:
            transport.write(_FULL)
            transport.close()

    def data_received(self, data: bytes) -> None:
        cast("Any", super()).data_received(data)
        if self._is_handed_on:
            return
        if self._is_asking:
            self._end()
            self.bounds.mark(self, silent=False)
        else:
            self._begin()
        if self._in_headers:
            self._num_header_bytes += len(data)
            if self._num_header_bytes > _MAX_HEADER_BYTES and not self.transport.is_closing():
                self.transport.write(_LARGE)
                self.transport.close()

    def on_message_begin(self) -> None:
        self._in_headers, self._num_header_bytes = True, 0
        cast("Any", super()).on_message_begin()

    def on_headers_complete(self) -> None:
        self._in_headers = False
        cast("Any", super()).on_headers_complete()

    def on_response_complete(self) -> None:
        cast("Any", super()).on_response_complete()
        self.bounds.mark(self, silent=True)

    def handle_websocket_upgrade(self) -> None:
        # From here on the connection is another protocol's, which counts it by itself.
        self._end()
        self._is_handed_on = True
        self.bounds.remove(self)
        cast("Any", super()).handle_websocket_upgrade()

    def connection_lost(self, exc: Exception | None) -> None:
        self._end()
        self.bounds.remove(self)
        cast("Any", super()).connection_lost(exc)

    @property
    def _is_asking(self) -> bool:
        return self.cycle is not None and not self.cycle.response_complete

    def _begin(self) -> None:
        if self._timer is None:
            self._timer = self.loop.call_later(self.bounds.header_timeout, self._on_late)

    def _end(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _on_late(self) -> None:
        self._timer = None
        if not self._is_asking and not self.transport.is_closing():
            self.transport.write(_LATE)
            self.transport.close()


def bounded_protocol(connections: Connections) -> type[asyncio.Protocol]:
    """Return uvicorn's protocol, for connections that are closed if they take too long."""
    bases = (_Bounded, cast("Any", HttpToolsProtocol))
    return type("BoundedProtocol", bases, {"bounds": connections})


class _BoundedSocket(WSProtocol):
    """Uvicorn's WebSockets, counted among the connections."""

    bounds: Connections

    @override
    def connection_made(self, transport: asyncio.Transport) -> None:
        super().connection_made(transport)
        self.bounds.add(self)
        self.bounds.mark(self, silent=False)

    @override
    def connection_lost(self, exc: Exception | None) -> None:
        self.bounds.remove(self)
        super().connection_lost(exc)


def bounded_socket(connections: Connections) -> type[asyncio.Protocol]:
    """Return uvicorn's protocol of WebSockets, each counted as one of the connections."""
    return type("BoundedSocket", (_BoundedSocket,), {"bounds": connections})
