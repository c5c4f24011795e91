"""The studio's page at `/`, and the WebSocket behind it, passed on to the studio's process.

Both stand behind the server's own guards of names and origins. They need no key: the process has no
rights of its own, and asks each browser for one if the server wants it.
"""

import asyncio
import contextlib
import logging
import re
from collections.abc import AsyncIterable, Awaitable, Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from service.studio import emptied, watch

HOST_HEADER = "X-Studio-Host"
TOKEN_HEADER = "X-Studio-Token"  # noqa: S105  (its name)
TOKEN_VARIABLE = "WAYPROOF_STUDIO_TOKEN"  # noqa: S105  (its name)
KEY_VARIABLE = "WAYPROOF_STUDIO_KEY"
# Browsers at once; each takes a thread or two, and megabytes where it shows many meshes.
_MAX_BROWSERS = 32
# WebSocket close codes (RFC 6455, section 7.4.1): an unexpected condition, and try again later.
_BROKEN, _TRY_LATER = 1011, 1013
# The page has everything in itself, compiles WebAssembly, and talks to this server alone.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; worker-src blob:; "
    "style-src 'unsafe-inline'; img-src 'self' data: blob:; font-src data:; "
    "connect-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_TITLE, _VISER_TITLE = "<title>Wayproof studio</title>", "<title>Viser</title>"
_ICON = (
    '<link rel="icon" href="data:image/svg+xml,%3Csvg xmlns=\'http://www.w3.org/2000/svg\' '
    "viewBox='0 0 32 32'%3E%3Crect width='32' height='32' rx='7' fill='%231d6fb8'/%3E%3Cpath "
    "d='M6 11l5 12 5-10 5 10 5-12' fill='none' stroke='white' stroke-width='3' "
    "stroke-linecap='round' stroke-linejoin='round'/%3E%3C/svg%3E\" />"
)
_VISER_ICON = re.compile(r'<link\s+rel="icon"[^>]*/>')

_log = logging.getLogger(__name__)

type Upstream = Callable[[], Awaitable[tuple[int, str]]]


def is_available() -> bool:
    """Return whether what draws the studio is installed: the extra `studio`."""
    return find_spec("viser") is not None and find_spec("websockets") is not None


def install(app: Starlette, upstream: Upstream, *, is_server: bool) -> None:
    """Have an application answer `/` with the studio, in place of what it answered before.

    Args:
        app: With its middleware.
        upstream: Returns the port of the studio's process, and the token that it wants.
        is_server: Whether it is the server that the studio asks: then it is asked by the name by
            which the browser knows it.
    """
    front = _Front(upstream, is_server=is_server)
    page = Route("/", front.page, methods=["GET"], include_in_schema=False)
    # Before the route that leads from `/` to the documentation.
    app.router.routes[:0] = [page, WebSocketRoute("/", front.socket)]


class _Front:
    def __init__(self, upstream: Upstream, *, is_server: bool) -> None:
        self._upstream, self._is_server = upstream, is_server
        self._page: str | None = None
        self._num_browsers = 0

    async def page(self, _: Request) -> Response:
        """Return viser's page under our name."""
        if self._page is None:
            self._page = await asyncio.to_thread(_read_page)
        headers = {"Content-Security-Policy": _POLICY, "Cache-Control": "no-cache"}
        return HTMLResponse(self._page, headers=headers)

    async def socket(self, browser: WebSocket) -> None:
        """Pass messages on between a browser and the studio, at the pace of the slower one."""
        if self._num_browsers >= _MAX_BROWSERS:
            await browser.close(_TRY_LATER)
            return
        self._num_browsers += 1
        try:
            await self._pass_on(browser)
        finally:
            self._num_browsers -= 1

    async def _pass_on(self, browser: WebSocket) -> None:
        from websockets.asyncio.client import connect  # noqa: PLC0415  (an extra)
        from websockets.exceptions import WebSocketException  # noqa: PLC0415

        asked = browser.scope.get("subprotocols", [])
        # At once: the process may take a second to start, and the page would come again.
        await browser.accept(asked[0] if asked else None)
        try:
            port, token = await self._upstream()
            name = browser.headers.get("host", "") if self._is_server else ""
            headers = {TOKEN_HEADER: token, HOST_HEADER: name}
            async with connect(
                f"ws://127.0.0.1:{port}",
                subprotocols=asked,
                additional_headers=headers,
                compression=None,
                max_size=None,
                proxy=None,
            ) as studio:
                try:
                    await _first_of(_to_studio(browser, studio.send), _to_browser(browser, studio))
                finally:
                    studio.transport.abort()  # one side has left: nothing more is to be said
        except (WebSocketException, OSError) as fault:
            _log.info("the studio left a browser: %s", fault)
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):  # the browser left first
            await browser.close(_BROKEN)


def _read_page() -> str:
    spec = find_spec("viser")
    if spec is None or spec.origin is None:
        raise FileNotFoundError("viser")
    page = Path(spec.origin).parent / "client" / "build" / "index.html"
    text = page.read_text(encoding="utf-8").replace(_VISER_TITLE, _TITLE, 1)
    text = _VISER_ICON.sub(lambda _: _ICON, text, count=1)
    head, end, rest = text.rpartition("</body>")
    return f"{head}{watch.SCRIPT}{emptied.SCRIPT}{end}{rest}"


async def _to_studio(browser: WebSocket, send: Callable[[bytes], Awaitable[None]]) -> None:
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            await send(await browser.receive_bytes())


async def _to_browser(browser: WebSocket, studio: AsyncIterable[Any]) -> None:
    async for message in studio:
        await browser.send_bytes(message)


async def _first_of(*ways: Awaitable[None]) -> None:
    """Wait until one way has ended, and end the other."""
    tasks = [asyncio.ensure_future(way) for way in ways]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
