"""Guard: middleware that lets in requests with a key of the right scope, and not too many of them.

A token of an identity provider is a key like any other here. Nothing of a body is read before.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from planning.errors import WayproofError
from service.api.dependencies import CALLER
from service.api.error_responses import ProblemResponse, respond
from service.errors import ScopeMissing, Unauthorized
from service.security.callers import Caller, Callers
from service.security.scopes import Scope as KeyScope
from service.security.scopes import required_scope
from service.settings import Settings

if TYPE_CHECKING:
    from service.security.request_limit import RequestLimit

# Answers that last as long as a job, which may be days: the key is looked at with each event.
_STREAMS = {"text/event-stream", "text/event-stream; charset=utf-8"}
_REALM = 'Bearer realm="wayproof"'
_END = {"type": "http.response.body", "body": b"", "more_body": False}
_CLOSE = {"type": "websocket.close", "code": 1008}


class _KeyEnded(Exception):
    """The key of a stream is not valid any more."""


class Guard:
    """Middleware that asks for keys, if the settings do, and counts requests."""

    def __init__(
        self,
        app: ASGIApp,
        settings: Settings,
        callers: Callable[[], Callers],
    ) -> None:
        """Guard `app`.

        Args:
            app: What gets the requests.
            settings: Whether there are keys, and how many requests are let in.
            callers: Returns who may ask, once the application runs.
        """
        self._app = app
        self._asks = settings.auth == "keys"
        self._callers = callers
        self._limit = _limit_of(settings)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        needed = None
        if scope["type"] in {"http", "websocket"}:
            needed = required_scope(scope.get("method", "GET"), scope["path"])
        if needed is None:
            await self._app(scope, receive, send)
            return
        given = Headers(scope=scope).getlist("authorization")
        key = await self._key(given) if self._asks else None
        if key is not None:
            scope[CALLER] = key.name
        answer = await self._refusal(scope, given, key, needed)
        if answer is not None:
            await answer(scope, receive, send)
        elif key is None:
            await self._app(scope, receive, send)
        else:
            await self._pass_on(key, scope, receive, send)

    async def _pass_on(self, key: Caller, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on; a stream of events ends when its key is not valid any more.

        So does a WebSocket (policy violation, RFC 6455).
        """
        callers, is_stream = self._callers(), False

        async def send_while_good(message: Message) -> None:
            nonlocal is_stream
            if message["type"] == "http.response.start":
                is_stream = Headers(raw=message["headers"]).get("content-type", "") in _STREAMS
            elif (is_stream or message["type"] == "websocket.send") and not callers.is_good(key):
                raise _KeyEnded
            await send(message)

        try:
            await self._app(scope, receive, send_while_good)
        except* _KeyEnded:
            await send(_CLOSE if scope["type"] == "websocket" else _END)

    async def _refusal(
        self, scope: Scope, given: list[str], key: Caller | None, needed: KeyScope
    ) -> ProblemResponse | None:
        # Who has no key is counted by address: guesses are requests as well.
        caller = (
            f"address {(scope.get('client') or ('',))[0]}"
            if key is None
            else f"{type(key).__name__} {key.id}"
        )
        late = None if self._limit is None else await self._limit.count(caller)
        if late is not None:
            return respond(late)
        return _refusal_of_key(key, needed, is_given=bool(given)) if self._asks else None

    async def _key(self, given: list[str]) -> Caller | None:
        kind, _, text = given[0].partition(" ") if len(given) == 1 else ("", "", "")
        return await self._callers().find(text.strip()) if kind.lower() == "bearer" else None


def _refusal_of_key(
    key: Caller | None, needed: KeyScope, *, is_given: bool
) -> ProblemResponse | None:
    """Return the answer to a request whose key is not good for it (RFC 6750, section 3)."""
    if key is None and is_given:
        message = "there is no such key, or it has expired or was revoked"
        return _challenge(Unauthorized(message), 'error="invalid_token"')
    if key is None:
        message = "a key is needed: `Authorization: Bearer wp_...`"
        return _challenge(Unauthorized(message))
    if key.allows(needed):
        return None
    scopes = sorted(key.scopes)
    message = f"the key {key.name!r} is for {', '.join(scopes)}; this needs {needed}"
    evidence = {"needed": str(needed), "scopes": [str(each) for each in scopes]}
    return _challenge(
        ScopeMissing(message, evidence), 'error="insufficient_scope"', f'scope="{needed}"'
    )


def _challenge(error: WayproofError, *parts: str) -> ProblemResponse:
    answer = respond(error)
    answer.headers["WWW-Authenticate"] = ", ".join([_REALM, *parts])
    return answer


def _limit_of(settings: Settings) -> "RequestLimit | None":
    """Return the limit of requests that the settings have; few servers have one."""
    if not settings.rate_limit:
        return None
    from service.security.request_limit import RequestLimit  # noqa: PLC0415  (takes a while)

    return RequestLimit(settings.rate_limit)
