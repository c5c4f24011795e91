"""ExactPaths: routes of the API whose paths have no parameters are found by one look."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from fastapi import APIRouter
from starlette.routing import BaseRoute, Match
from starlette.types import Receive, Scope, Send

from service.api.routing.strict_route import StrictRoute

_TRACED = "fastapi.telemetry"


class ExactPaths:
    """Finds the route of a request; a router asks one route after the other.

    A route is known here if it is the first that takes the request; all else the router looks for.
    """

    def __init__(self, router: APIRouter) -> None:
        """Stand before a router, which has all its routes by the first request."""
        self._router = router

    @cached_property
    def known(self) -> dict[tuple[str, str], tuple[StrictRoute, Scope]]:
        """Routes by method and path, and what each adds to the scope."""
        every = self._router.routes
        return {
            (method, route.path): (route, child)
            for route in every
            if isinstance(route, StrictRoute) and "{" not in route.path
            for method in route.methods or ()
            for first, child in [_first(every, method, route.path)]
            if first is route
        }

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on to its route."""
        known = self.known.get((scope.get("method", ""), scope.get("path", "")))
        if known is None or scope.get("root_path") or scope.get(_TRACED) is not None:
            await self._router.app(scope, receive, send)
            return
        route, child = known
        scope.update(child, router=self._router, path_params={})
        await route.handle(scope, receive, send)


def _first(
    routes: Sequence[BaseRoute], method: str, path: str
) -> tuple[BaseRoute | None, dict[str, Any]]:
    """Return the first route that takes a request, and what it adds to the scope."""
    scope: Scope = {"type": "http", "method": method, "path": path, "headers": []}
    for route in routes:
        match, child = route.matches(scope)
        if match == Match.FULL:
            return route, dict(child)
    return None, {}
