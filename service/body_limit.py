"""BodyLimit: bodies that are too long are refused before they are in memory."""

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.errors import BodyTooLarge
from service.problems import respond

# Everything but a scene is small: a thousand goals of a hundred joints are 2 MB.
MAX_SMALL_BODY = 4 * 1024 * 1024
_LARGE = "/v1/scenes"


class BodyLimit:
    """Middleware that counts what arrives, whatever `Content-Length` says."""

    def __init__(self, app: ASGIApp, max_scene_bytes: int) -> None:
        """Protect `app`; scenes may have `max_scene_bytes`, all else less."""
        self._app = app
        self._max_scene_bytes = max_scene_bytes

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
        counted = _Counted(receive, bound)
        await self._app(scope, counted, send)


class _Counted:
    """A `receive` that stops at a number of bytes."""

    def __init__(self, receive: Receive, bound: int) -> None:
        self._receive = receive
        self._bound = bound
        self._total = 0

    async def __call__(self) -> Message:
        message = await self._receive()
        self._total += len(message.get("body", b""))
        if self._total > self._bound:
            # FastAPI turns any other exception in here into "cannot be parsed".
            raise HTTPException(413, _too_large(self._bound).detail)
        return message


def _too_large(bound: int) -> BodyTooLarge:
    return BodyTooLarge(f"the body has more than {bound} bytes", {"bound": bound})
