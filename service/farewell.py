"""Farewell: what the end of the server cuts off is answered, so that clients know to ask again."""

import asyncio
from collections.abc import Callable

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.errors import ServerStopping
from service.problems import respond


class Farewell:
    """Middleware that answers 503 to requests that are canceled because the server ends."""

    def __init__(self, app: ASGIApp, is_stopping: Callable[[], bool]) -> None:
        """Stand around `app`.

        Args:
            app: Answers.
            is_stopping: Whether the server ends, so that a cancel is its doing.
        """
        self._app = app
        self._is_stopping = is_stopping

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        has_begun = False

        async def told(message: Message) -> None:
            nonlocal has_begun
            has_begun = True
            await send(message)

        try:
            await self._app(scope, receive, told)
        except asyncio.CancelledError:
            if scope["type"] != "http" or has_begun or not self._is_stopping():
                raise
            message = "the server ends and could not finish this; ask again when it is back"
            await respond(ServerStopping(message))(scope, receive, send)
