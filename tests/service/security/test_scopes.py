"""Every operation needs the scope that is written here: a new one is a decision."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.security.scopes import Scope, required_scope
from tests.service.api_routes import api_routes

CHANGES = {
    "createScene": "plan", "editScene": "plan", "deleteScene": "plan",
    "checkConfigurations": "plan", "computeForwardKinematics": "plan",
    "solveInverseKinematics": "plan", "traceLine": "plan",
    "growRegions": "plan", "cancelRegions": "plan", "deleteRegions": "plan",
    "createPlan": "plan", "reversePlan": "plan", "cancelPlan": "plan", "deletePlan": "plan",
    "createBatch": "plan", "cancelBatch": "plan", "deleteBatch": "plan",
    "retimePath": "plan", "certifyTrajectory": "plan", "stopMotion": "plan",
    "scheduleMotions": "plan",
    "spliceMotion": "plan",
    "createExecution": "execute", "cancelExecution": "execute", "pauseExecution": "execute",
    "resumeExecution": "execute", "setExecutionSpeed": "execute", "deleteExecution": "execute",
    # Who registers an address is told of everything.
    "createWebhook": "admin", "listWebhooks": "admin", "getWebhook": "admin",
    "enableWebhook": "admin", "deleteWebhook": "admin",
}  # fmt: skip
OPEN = {"getHealth", "getReadiness"}


def test_every_operation_needs_the_scope_of_this_table():
    found = {
        route.operation_id: required_scope(method, route.path_format)
        for route in api_routes()
        for method in route.methods
    }
    reads = {name for name in found if name.startswith(("get", "list", "stream"))}
    expected = dict.fromkeys(reads, "read") | CHANGES | {"getMetrics": "admin"}
    assert found == expected | dict.fromkeys(OPEN)


def test_the_document_says_the_same(document):
    assert document["components"]["securitySchemes"]["key"]["scheme"] == "bearer"
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            scope = required_scope(method.upper(), path)
            needed = [] if scope is None else [{"key": [str(scope)]}, {}]
            assert operation["security"] == needed, (method, path)
            declared = {"401", "429"} & set(operation["responses"])
            assert declared == (set() if scope is None else {"401", "429"}), (method, path)


OPEN_PATHS = {"/", "/healthz", "/readyz", "/docs", "/openapi.json"}


@given(
    st.sampled_from(["GET", "POST", "PUT", "PATCH", "DELETE", "X"]),
    st.text("/v1abc.%", max_size=12),
)
def test_a_path_that_is_not_listed_needs_a_key(method, rest):
    path = f"/{rest}"
    assert path in OPEN_PATHS or required_scope(method, path) is not None


def taken_for(method, path):
    """The routes that the router may take a request for."""
    return [r for r in api_routes() if method in r.methods and r.path_regex.match(path)]


@pytest.mark.parametrize("letter", ["\n", "\r", " ", ".", "\0", "\u2028"])
def test_what_the_router_takes_for_a_route_needs_the_scope_of_that_route(letter):
    """A `$` in the expressions of routes lets a line break at the end pass."""
    num_taken = 0
    for route in api_routes():
        (method,), whole = route.methods, route.path_format
        for at in range(len(whole) + 1):
            path = whole[:at] + letter + whole[at:]
            for taken in taken_for(method, path):
                num_taken += 1
                needed = required_scope(method, taken.path_format)
                assert required_scope(method, path) == needed, path
    assert num_taken > 0


@pytest.mark.parametrize("path", ["/healthz/", "/docsx", "/metrics", "/v1/executionsx"])
def test_paths_that_begin_like_others_are_not_taken_for_them(path):
    assert required_scope("POST", path) in {Scope.PLAN, Scope.ADMIN}
