"""DisconnectWatch: what is asked for a client ends when the client leaves, and says what it took.

A question runs for one client alone, so nothing is left to do for it once the connection is closed.
Jobs are not watched: they were accepted, and end by `cancel`.
"""

import asyncio
from collections.abc import Coroutine
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.errors import ClientLeft
from service.jobs.dispatch.calls import CallResult


@dataclass
class _Client:
    """Who sent the request that this task answers.

    Attributes:
        receive: What ASGI has of the client.
        waited: What its questions waited for a worker so far [s].
        worked: What workers did for them so far [s].
        has_asked: Whether it asked any.
    """

    receive: Receive
    waited: float = 0.0
    worked: float = 0.0
    has_asked: bool = False

    @property
    def timing(self) -> str:
        """The value of `Server-Timing` (W3C), in milliseconds."""
        return f"queue;dur={1000 * self.waited:.1f}, work;dur={1000 * self.worked:.1f}"


_client: ContextVar[_Client | None] = ContextVar("client", default=None)


class DisconnectWatch:
    """Middleware that knows whose request a task answers, and adds `Server-Timing`."""

    def __init__(self, app: ASGIApp) -> None:
        """Watch the clients of `app`."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        client = _Client(receive)

        async def send_timed(message: Message) -> None:
            if message["type"] == "http.response.start" and client.has_asked:
                MutableHeaders(scope=message)["Server-Timing"] = client.timing
            await send(message)

        token = _client.set(client)
        try:
            await self._app(scope, receive, send_timed)
        finally:
            _client.reset(token)


async def call_for_client(call: Coroutine[Any, Any, CallResult]) -> CallResult:
    """Return the result of a call, which ends if the client leaves, and note what it took.

    Raises:
        ClientLeft: The client closed its connection.
    """
    result = await unless_client_leaves(call)
    client = _client.get()
    if client is not None:
        client.has_asked = True
        client.waited += result.waited
        client.worked += result.worked
    return result


async def unless_client_leaves[T](work: Coroutine[Any, Any, T]) -> T:
    """Return what work gives; cancel it when the client of this request closes its connection.

    The body of the request must have been read.

    Raises:
        ClientLeft: It has.
    """
    client = _client.get()
    if client is None:
        return await work
    task = asyncio.ensure_future(work)
    watch = asyncio.ensure_future(_left(client.receive))
    try:
        await asyncio.wait({task, watch}, return_when=asyncio.FIRST_COMPLETED)
        if not task.done():
            message = "the client closed its connection before it had its answer"
            raise ClientLeft(message)
        return task.result()
    finally:
        task.cancel()
        watch.cancel()
        await asyncio.gather(task, watch, return_exceptions=True)


async def _left(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
