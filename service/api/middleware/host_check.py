"""HostCheck: requests are let in by the name of the server and the origin of the page.

A browser asks on behalf of any page: one that has its own name resolve to 127.0.0.1 (DNS rebinding)
gives itself away by `Host`, and one that asks another server by `Origin` (RFC 6454).
"""

from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from service.api.error_responses import respond
from service.errors import HostNotAllowed, OriginNotAllowed, Refusal
from service.settings import Settings

_ANY = "*"


class HostCheck:
    """Middleware that lets in what is meant for this server."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        """Guard `app`."""
        self._app = app
        self._hosts = [host.lower() for host in settings.hosts]
        self._origins = [origin.lower() for origin in settings.allowed_origins]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        is_request = scope["type"] in {"http", "websocket"}
        refusal = self._refusal(Headers(scope=scope)) if is_request else None
        if refusal is None:
            await self._app(scope, receive, send)
        else:
            await respond(refusal)(scope, receive, send)

    def _refusal(self, headers: Headers) -> Refusal | None:
        named = headers.getlist("host")
        host = named[0].lower() if len(named) == 1 else ""
        if not any(_is_like(_name_of(host), pattern) for pattern in self._hosts):
            message = f"this server is not called {host[:80]!r}: WAYPROOF_ALLOWED_HOSTS names it"
            return HostNotAllowed(message, {"host": host[:80]})
        origin = headers.get("origin")
        if origin is None or self._is_let_in(origin.lower(), host):
            return None
        message = f"pages of {origin[:80]!r} may not ask this server: WAYPROOF_ALLOWED_ORIGINS "
        return OriginNotAllowed(message + "names those that may", {"origin": origin[:80]})

    def _is_let_in(self, origin: str, host: str) -> bool:
        return bool(
            _ANY in self._origins or origin in self._origins or _authority(origin) == host != ""
        )


def _authority(origin: str) -> str:
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return ""


def _name_of(host: str) -> str:
    """Return a host without its port; addresses of version 6 keep their brackets."""
    if host.startswith("["):
        return host.partition("]")[0] + "]"
    return host.partition(":")[0].removesuffix(".")


def _is_like(name: str, pattern: str) -> bool:
    is_below = pattern.startswith("*.") and name.endswith(pattern[1:])
    return pattern in (_ANY, name) or is_below
