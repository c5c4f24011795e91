"""What is found by one look is what the router would find."""

import pytest
from starlette.responses import Response
from starlette.routing import Match, Route

from service.api.routing.exact_paths import ExactPaths
from service.app import create_app


@pytest.fixture(scope="module")
def routes(app):
    return app.router.routes


def found(routes, method, path):
    """Return the first route that takes a request."""
    scope = {"type": "http", "method": method, "path": path, "headers": []}
    return next((r for r in routes if r.matches(dict(scope))[0] is Match.FULL), None)


def test_what_is_known_is_the_first_route_that_takes_the_request(app, routes):
    known = ExactPaths(app.router).known
    assert ("POST", "/v1/plans") in known
    for (method, path), (route, added) in known.items():
        assert route is found(routes, method, path)
        assert added["route"] is route
        assert added["endpoint"] is route.endpoint


def test_a_route_that_comes_before_is_asked_first(settings):
    app = create_app(settings)
    page = Route("/v1/plans", lambda _: Response("page"), methods=["GET"])
    app.router.routes[:0] = [page]
    known = app.router.middleware_stack.known
    assert ("GET", "/v1/plans") not in known
    assert ("POST", "/v1/plans") in known


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [("GET", "/v1/plans", 200), ("PUT", "/v1/plans", 405), ("GET", "/v1/plans/", 404)],
)
def test_all_else_is_answered_as_ever(client, method, path, status):
    assert client.request(method, path).status_code == status
