"""Audit: one line of the log for every request that changes something, or was not let in.

The logger is `wayproof.audit`; a line is a JSON object: `caller` (name of the key, null without
one), `operation` (id, else null), `method`, `path`, `resource` (the answer's `Location`, or what
the path names), `status` (null where nothing was answered), `request_id`. Nothing else of a request
is written: no header, no body.
"""

import json
import logging

from fastapi.routing import APIRoute
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.dependencies import CALLER
from service.api.middleware.request_id import request_id
from service.security.scopes import SAFE_METHODS
from service.telemetry.masking import redacted

_log = logging.getLogger("wayproof.audit")
# Questions are posted, because they are long, and change nothing.
_QUESTIONS = frozenset({"queries", "trajectories"})
_NOT_LET_IN = frozenset({401, 403})
_MAX_PATH = 200


class Audit:
    """Middleware that writes what is done, once its answer is on its way."""

    def __init__(self, app: ASGIApp) -> None:
        """Stand around `app`."""
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        is_noted, status, headers = False, None, Headers()

        async def send_noted(message: Message) -> None:
            nonlocal is_noted, status, headers
            if message["type"] == "http.response.start":
                status, headers = message["status"], Headers(raw=message["headers"])
            await send(message)
            # After the first piece of the body: a stream may last, and the client need not wait.
            if message["type"] == "http.response.body" and not is_noted:
                is_noted = True
                _note(scope, status, headers)

        try:
            await self._app(scope, receive, send_noted)
        except Exception:
            status = status or 500  # what answers unexpected errors stands around all middleware
            raise
        finally:
            if not is_noted:
                _note(scope, status, headers)


def _note(scope: Scope, status: int | None, headers: Headers) -> None:
    route = scope.get("route")
    if not (isinstance(route, APIRoute) and scope["method"] in route.methods):
        route = None
    is_question = route is not None and bool(_QUESTIONS & set(route.tags))
    is_change = scope["method"] not in SAFE_METHODS and not is_question
    if not (is_change or status in _NOT_LET_IN):
        return
    named = list(scope.get("path_params", {}).values()) or [None]
    entry = {
        "caller": scope.get(CALLER),
        "operation": None if route is None else route.operation_id,
        "method": scope["method"],
        "path": redacted(scope["path"])[:_MAX_PATH],
        "resource": headers.get("location") or named[0],
        "status": status,
        "request_id": request_id(),
    }
    _log.info("%s", redacted(json.dumps(entry, default=str)))
