"""A route says quickly that a request is not for it, and never that of one which is."""

from fastapi.routing import APIRoute
from hypothesis import given, settings
from hypothesis import strategies as st
from starlette.routing import Match

from service.api.routing.strict_route import StrictRoute
from service.app import PARTS
from tests.profiles import num_cases

ROUTES = [route for part in PARTS for route in part.router.routes if isinstance(route, StrictRoute)]
PARTS_OF_PATHS = ["", "v1", "v1x", "plans", "scenes", "pln_1", "events", "%7B", "{plan}", "batch"]
PATHS = [route.path.replace("{", "").replace("}", "") for route in ROUTES]


@given(
    st.one_of(
        st.sampled_from(PATHS),
        st.lists(st.sampled_from(PARTS_OF_PATHS)).map(lambda parts: "/" + "/".join(parts)),
    ),
    st.sampled_from(["", "/v1", "/behind"]),
    st.sampled_from(["GET", "POST", "DELETE"]),
)
@settings(max_examples=num_cases(60), deadline=None)
def test_a_look_at_how_a_path_begins_changes_no_match(path, root, method):
    scope = {"type": "http", "method": method, "root_path": root, "path": root + path}
    found = [route.matches(dict(scope))[0] for route in ROUTES]
    assert found == [APIRoute.matches(route, dict(scope))[0] for route in ROUTES]


def test_each_route_takes_its_own_path():
    for route, path in zip(ROUTES, PATHS, strict=True):
        scope = {"type": "http", "method": min(route.methods), "path": path}
        assert route.matches(scope)[0] is Match.FULL
