"""AsyncCaller: sends calls without holding up the event loop."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any, Self

import httpx

from wayproof_client.call import Call
from wayproof_client.connection import (
    ANSWER_TIMEOUT,
    adapter,
    after,
    options,
    request_of,
    retries,
    stream_of,
)
from wayproof_client.errors import checked
from wayproof_client.events import async_decode_events


class AsyncCaller:
    """Speaks to one server. Use it as an asynchronous context manager, or close it."""

    def __init__(
        self,
        url: str,
        *,
        key: str | None = None,
        timeout: float = ANSWER_TIMEOUT,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        """Speak to a server: arguments as of `Caller`."""
        self._timeout = timeout
        self._http = httpx.AsyncClient(**options(url, key, timeout), transport=transport)

    async def __aenter__(self) -> Self:
        """Begin to use it."""
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close all connections."""
        await self.close()

    async def close(self) -> None:
        """Close all connections."""
        await self._http.aclose()

    async def ask(self, call: Call, kind: Any) -> Any:
        """Return the answer as a model."""
        return adapter(kind).validate_json((await self.send(call)).content)

    async def ask_nothing(self, call: Call) -> None:
        """Send a call whose answer is empty."""
        await self.send(call)

    async def ask_text(self, call: Call) -> str:
        """Return the answer as a text."""
        return (await self.send(call)).text

    async def ask_bytes(self, call: Call) -> bytes:
        """Return the answer as it came."""
        return (await self.send(call)).content

    async def ask_events(self, call: Call, kind: Any) -> AsyncIterator[Any]:
        """Yield events as `Caller.ask_events` does."""
        last, left = "", retries()
        while True:
            try:
                async with self._http.stream(**stream_of(after(call, last))) as answer:
                    if answer.is_error:
                        await answer.aread()
                    async for event in async_decode_events(checked(answer)):
                        last, left = event.id or last, retries()
                        yield adapter(kind).validate_python(event.document)
            except httpx.TransportError:
                pause = next(left, None)
                if pause is None:
                    raise
                await self._pause(pause)
            else:
                return

    async def send(self, call: Call) -> httpx.Response:
        """Return the response to a call, or raise as `Caller.send` does."""
        return checked(await self._http.request(**request_of(call, self._timeout)))

    async def _pause(self, seconds: float) -> None:
        await asyncio.sleep(seconds)
