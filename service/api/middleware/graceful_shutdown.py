"""GracefulShutdown: what the end of the server cuts off is answered, and clients ask again."""

import asyncio
from collections.abc import Callable

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.error_responses import respond
from service.errors import ServerStopping

_EVENTS = "text/event-stream"


class GracefulShutdown:
    """Middleware that ends in order what is canceled because the server ends.

    A request is answered 503; a stream of events just ends, and who follows it asks for the rest.
    """

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
        begun: Headers | None = None

        async def told(message: Message) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = Headers(raw=message["headers"])
            await send(message)

        try:
            await self._app(scope, receive, told)
        except asyncio.CancelledError:
            if scope["type"] != "http" or not self._is_stopping():
                raise
            if begun is None:
                message = "the server ends and could not finish this; ask again when it is back"
                await respond(ServerStopping(message))(scope, receive, send)
            elif begun.get("content-type", "").startswith(_EVENTS):
                await send({"type": "http.response.body", "body": b"", "more_body": False})
            else:
                raise
