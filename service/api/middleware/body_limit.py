"""BodyLimit: bodies that are too long, or take too long, are refused before they are in memory."""

import asyncio

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.error_responses import respond
from service.api.routing.strict_route import CarriedRefusal
from service.errors import BodyTooLarge, RequestTimeout

# Everything but a scene is small: a thousand goals of a hundred joints are 2 MB.
MAX_SMALL_BODY = 4 * 1024 * 1024
_LARGE = "/v1/scenes"


class BodyLimit:
    """Middleware that counts what arrives, whatever `Content-Length` says."""

    def __init__(self, app: ASGIApp, max_scene_bytes: int, allowed: float) -> None:
        """Protect `app`.

        Args:
            app: What gets the requests.
            max_scene_bytes: That scenes may have; all else less.
            allowed: For a body to arrive [s].
        """
        self._app = app
        self._max_scene_bytes = max_scene_bytes
        self._allowed = allowed

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        bound = self._max_scene_bytes
        if scope["path"] != _LARGE:
            bound = min(bound, MAX_SMALL_BODY)
        announced = Headers(scope=scope).get("content-length", "0")
        if announced.isdecimal() and int(announced) > bound:
            await respond(_too_large(bound))(scope, receive, send)
            return
        counted = _Counted(receive, bound, self._allowed)
        await self._app(scope, counted, send)


class _Counted:
    """A `receive` that stops at a number of bytes, and at an instant while there are more."""

    def __init__(self, receive: Receive, bound: int, allowed: float) -> None:
        self._receive = receive
        self._bound = bound
        self._allowed = allowed
        self._until = asyncio.get_running_loop().time() + allowed
        self._has_more = True
        self._total = 0

    async def __call__(self) -> Message:
        message = await self._next() if self._has_more else await self._receive()
        self._has_more = message["type"] == "http.request" and message.get("more_body", False)
        self._total += len(message.get("body", b""))
        if self._total > self._bound:
            # FastAPI turns any other exception in here into "cannot be parsed".
            raise CarriedRefusal(_too_large(self._bound))
        return message

    async def _next(self) -> Message:
        try:
            async with asyncio.timeout_at(self._until):
                return await self._receive()
        except TimeoutError as late:
            message = f"the body did not arrive within {self._allowed:g} s"
            raise CarriedRefusal(RequestTimeout(message, {"allowed": self._allowed})) from late


def _too_large(bound: int) -> BodyTooLarge:
    return BodyTooLarge(f"the body has more than {bound} bytes", {"bound": bound})
