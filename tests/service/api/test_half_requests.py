"""Requests that never end are ended; a flood of them does not keep others out."""

import asyncio
import contextlib
import socket
import threading
from contextlib import contextmanager

import pytest
import uvicorn

from service.api.middleware.body_limit import BodyLimit
from service.cli.connections import Connections, bounded_protocol

HALF = b"POST /x HTTP/1.1\r\nHost: x\r\n"
WHOLE = b"GET /x HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
# Against tests that hang.
GUARD = 60


async def app(scope, receive, send):
    while (await receive()).get("more_body"):
        pass
    await send({"type": "http.response.start", "status": 204, "headers": []})
    await send({"type": "http.response.body"})


@contextmanager
def serving(most, header_timeout):
    """Uvicorn in a thread, and how to connect to it."""
    with socket.create_server(("127.0.0.1", 0)) as bound:
        connections = Connections(most, header_timeout)
        protocol = bounded_protocol(connections)
        config = uvicorn.Config(app, http=protocol, log_level="critical", lifespan="off")
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [bound]})
        address = bound.getsockname()
        thread.start()
        try:
            yield lambda: socket.create_connection(address, GUARD)
        finally:
            server.should_exit = True
            thread.join(GUARD)


def answer(connection):
    """All that comes, to the end."""
    with connection:
        parts = []
        while part := connection.recv(4096):
            parts.append(part)
        return b"".join(parts)


def test_headers_that_do_not_end_are_not_waited_for():
    with serving(most=10, header_timeout=0.1) as connect:
        half = connect()
        half.sendall(HALF)
        assert answer(half).startswith(b"HTTP/1.1 408")
        silent = connect()
        assert answer(silent).startswith(b"HTTP/1.1 408")


def test_a_second_request_is_not_waited_for_either():
    with serving(most=10, header_timeout=0.1) as connect:
        kept = connect()
        kept.sendall(WHOLE.replace(b"Connection: close\r\n", b""))
        assert kept.recv(4096).startswith(b"HTTP/1.1 204")
        kept.sendall(HALF)
        assert answer(kept).startswith(b"HTTP/1.1 408")


def test_a_flood_of_half_requests_keeps_nobody_out():
    with serving(most=5, header_timeout=GUARD) as connect:
        flood = [connect() for _ in range(20)]
        for half in flood:
            half.sendall(HALF)
        for _ in range(10):
            whole = connect()
            whole.sendall(WHOLE)
            assert answer(whole).startswith(b"HTTP/1.1 204")
        for half in flood:
            half.close()


def test_there_is_an_end_to_connections_that_are_being_answered():
    with serving(most=2, header_timeout=GUARD) as connect:
        bodies = [connect() for _ in range(2)]
        for body in bodies:
            body.sendall(HALF + b"Content-Length: 9\r\nExpect: 100-continue\r\n\r\n")
            assert body.recv(4096).startswith(b"HTTP/1.1 100")  # now it is being answered
        assert answer(connect()).startswith(b"HTTP/1.1 503")
        for body in bodies:
            body.sendall(b"123456789")
            assert body.recv(4096).startswith(b"HTTP/1.1 204")
            body.close()


@pytest.mark.parametrize("parts", [0, 1, 3])
def test_a_body_that_does_not_end_is_answered_408(parts):
    from service.app import create_app
    from service.settings import Settings

    limited = BodyLimit(create_app(Settings(engine="inline")), 10**6, allowed=0.01)
    sent = [{"type": "http.request", "body": b" ", "more_body": True}] * parts
    told = []

    async def receive():
        return sent.pop() if sent else await asyncio.Event().wait()

    async def send(message):
        told.append(message)

    headers = [(b"host", b"localhost"), (b"content-type", b"application/json")]
    headers += [(b"content-length", b"9")]
    scope = {"type": "http", "asgi": {"version": "3.0"}, "http_version": "1.1", "method": "POST"}
    scope |= {"path": "/v1/plans", "raw_path": b"/v1/plans", "query_string": b"", "root_path": ""}
    scope |= {"scheme": "http", "server": ("localhost", 80), "client": None, "headers": headers}
    asyncio.run(asyncio.wait_for(limited(scope, receive, send), GUARD))
    assert told[0]["status"] == 408
    assert (b"connection", b"close") in told[0]["headers"]
    assert b"request_timeout" in told[1]["body"]


def test_headers_that_are_too_large_are_not_kept():
    with serving(most=10, header_timeout=GUARD) as connect:
        large = connect()
        large.sendall(HALF)
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            for _ in range(100):
                large.sendall(b"X: " + b"a" * 4000 + b"\r\n")
        assert large.recv(4096).startswith(b"HTTP/1.1 431")
        large.close()


def test_a_body_is_no_header_even_if_it_was_answered_before_it_ended():
    with serving(most=10, header_timeout=GUARD) as connect:
        kept = connect()
        body = b"a" * 200_000
        for _ in range(3):
            kept.sendall(HALF + b"Content-Length: %d\r\n\r\n" % len(body) + body)
            assert kept.recv(4096).startswith(b"HTTP/1.1 204")
        kept.close()
