"""How to reach a server, and what both callers do alike with what it answers."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import repeat
from typing import Any
from urllib.parse import urlsplit

import httpx
from pydantic import TypeAdapter

from wayproof_client.call import Call

CONNECT_TIMEOUT = 5.0
ANSWER_TIMEOUT = 120.0
# Of a stream, in which the server says that it is there every few seconds [s].
SILENCE = 60.0
_LOOPBACK = {"localhost", "127.0.0.1", "::1"}
_ANSWERS = {"Accept": "application/json, application/problem+json"}


def options(url: str, key: str | None, timeout: float) -> dict[str, Any]:
    """Return the options of an `httpx` client of a server."""
    return {
        "base_url": url,
        "headers": {} if key is None else {"Authorization": f"Bearer {key}"},
        "timeout": httpx.Timeout(timeout, connect=CONNECT_TIMEOUT),
        # Proxies of the environment are for the world, not for a server on this machine. To read
        # the certificates of the world takes 20 ms, and plain HTTP has no use for them.
        "trust_env": urlsplit(url).hostname not in _LOOPBACK,
        "verify": not url.startswith("http://"),
    }


def request_of(call: Call, timeout: float) -> dict[str, Any]:
    """Return the arguments of a request, which may take as long as it asks to wait, and longer."""
    return call.request() | {
        "timeout": httpx.Timeout(timeout + call.waits, connect=CONNECT_TIMEOUT)
    }


def stream_of(call: Call) -> dict[str, Any]:
    """Return the arguments of a request for a stream."""
    return call.request() | {"timeout": httpx.Timeout(SILENCE, connect=CONNECT_TIMEOUT)}


def after(call: Call, last: str) -> Call:
    """Return a call for a stream's events after the last one that came."""
    return replace(call, headers={**call.headers, "Last-Event-ID": last}) if last else call


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return what turns JSON into a model, or one of a union of them."""
    return TypeAdapter(kind)


def pauses() -> Iterator[float]:
    """Yield how long to wait before each further look [s]: 10 ms at first, then ever longer."""
    pause = 0.01
    while pause < 0.5:
        yield pause
        pause *= 1.5
    yield from repeat(0.5)


def retries() -> Iterator[float]:
    """Yield how long to wait before each further try to go on with a stream that broke [s]."""
    yield from (0.1, 0.3, 1.0, 3.0, 5.0)
