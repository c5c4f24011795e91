"""Answers leave at once: no connection waits to send more at a time (Nagle's algorithm)."""

import asyncio
import socket

import pytest
import uvloop
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from service.cli.connections import Connections, bounded_protocol
from service.cli.serve import bind


@pytest.mark.parametrize("loop", [asyncio.new_event_loop, uvloop.new_event_loop])
def test_what_is_accepted_sends_at_once(loop):
    async def story():
        told = asyncio.get_running_loop().create_future()

        def accepted(_, writer):
            own = writer.get_extra_info("socket")
            told.set_result(own.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        bound = bind("127.0.0.1", 0)
        async with await asyncio.start_server(accepted, sock=bound):
            _, writer = await asyncio.open_connection(*bound.getsockname())
            assert await told
            writer.close()
            await writer.wait_closed()

    with asyncio.Runner(loop_factory=loop) as runner:
        runner.run(story())


def test_requests_are_parsed_by_native_code():
    assert issubclass(bounded_protocol(Connections(1, 1.0)), HttpToolsProtocol)
