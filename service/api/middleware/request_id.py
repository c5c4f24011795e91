"""RequestId: `X-Request-ID` in every answer, and in the log records that belong to a request."""

import re
from secrets import token_hex

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.telemetry.ids import REQUEST, bind_ids, bound_ids
from service.telemetry.traces import trace_ids

HEADER = "X-Request-ID"
_SANE = re.compile(r"[A-Za-z0-9._-]{1,64}")


def request_id() -> str:
    """Return the id of the request that this task answers, "" outside of one."""
    return bound_ids().get(REQUEST, "")


class RequestId:
    """Middleware that takes the id of a request from its header, or makes one."""

    def __init__(self, app: ASGIApp) -> None:
        """Stand around `app`."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        given = Headers(scope=scope).getlist(HEADER)
        is_sane = len(given) == 1 and _SANE.fullmatch(given[0])
        name = given[0] if is_sane else token_hex(16)
        # Not reset: each request is answered by a task of its own, and what handles unexpected
        # errors and logs the access stands around this middleware.
        bind_ids({REQUEST: name, **trace_ids()})

        async def send_named(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)[HEADER] = name
            await send(message)

        await self._app(scope, receive, send_named)
