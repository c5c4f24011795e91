"""A request that is read at once is answered as FastAPI would have it answered."""

import asyncio
import json
from typing import Annotated

import pytest
from fastapi import APIRouter, FastAPI, Header, Query, Request, Response
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field

from planning.errors import UnknownName
from service.api import error_responses
from service.api.routing.straight_route import StraightRoute
from service.api.routing.strict_route import StrictRoute
from service.plans import routes as plans
from tests.profiles import num_cases


class Asked(BaseModel):
    model_config = ConfigDict(extra="forbid")

    name: str = Field(min_length=1)
    numbers: list[float] = []
    more: dict[str, int] = {}


async def endpoint(  # noqa: PLR0913  (all that a request says)
    asked: Asked,
    http: Request,
    response: Response,
    *,
    wait: Annotated[float | None, Query(ge=0, le=100)] = None,
    include: Annotated[str | None, Query(max_length=4)] = None,
    prefer: Annotated[str | None, Header(max_length=8)] = None,
    key: Annotated[str | None, Header(alias="Idempotency-Key", min_length=1)] = None,
) -> Response:
    if asked.name == "none":
        raise UnknownName.among("name", asked.name, ["one"])
    response.headers["Location"] = "/x"
    told = {**asked.model_dump(), "wait": wait, "include": include, "prefer": prefer, "key": key}
    told |= {"status": response.status_code, "path": http.url.path, "first": dict(response.headers)}
    return Response(json.dumps(told), 202, dict(response.headers), "application/json")


def app_of(route_class):
    app, router = FastAPI(), APIRouter(route_class=route_class)
    router.post("/x", status_code=202)(endpoint)
    error_responses.install(app)
    app.router.routes.extend(router.routes)
    return app


STRAIGHT, USUAL = app_of(StraightRoute), app_of(StrictRoute)
JSON = b"application/json"
BODIES = [
    b'{"name": "one"}',
    b'{"name": "one", "numbers": [1, 2.5], "more": {"a": 1}}',
    b'{"name": "none"}',
    b'{"name": ""}',
    b'{"name": "one", "more": {"a": "b"}}',
    b'{"name": "one", "name": "two"}',
    b'{"name": "one", "numbers": [NaN]}',
    b'{"name": "\xff"}',
    b'{"name": 3, "x": 1}',
    b"{",
    b"[1]",
    b"null",
    b"",
]
QUERIES = [b"wait=3", b"wait=0.5", b"wait=%31", b"wait=1e+1", b"wait=", b"wait", b"wait=x"]
QUERIES += [b"wait=-1", b"include=ab", b"include=abcde", b"include=%00", b"other=1", b"", b"wait=7"]
HEADERS = [
    (b"prefer", b"wait=1"),
    (b"prefer", b"much too long"),
    (b"prefer", b"\xe4"),
    (b"idempotency-key", b"k"),
    (b"idempotency-key", b""),
    (b"content-type", JSON),
    (b"content-type", b"application/json; charset=utf-8"),
    (b"content-type", b"text/plain"),
    (b"x-other", b"1"),
]


async def answer(app, query, headers, pieces):
    """Return status, headers and body of the answer to a request whose body comes in pieces."""
    scope = {"type": "http", "asgi": {"version": "3.0"}, "http_version": "1.1", "method": "POST"}
    scope |= {"scheme": "http", "path": "/x", "raw_path": b"/x", "query_string": query}
    scope |= {"root_path": "", "headers": headers, "client": ("here", 1), "server": ("there", 2)}
    sent, left = [], list(pieces)

    async def receive():
        if not left:
            return {"type": "http.disconnect"}
        piece = left.pop(0)
        if piece is None:
            return {"type": "http.disconnect"}
        return {"type": "http.request", "body": piece, "more_body": bool(left)}

    async def send(message):
        sent.append(message)

    await app(scope, receive, send)
    start, *bodies = sent
    body = b"".join(message.get("body", b"") for message in bodies)
    return start["status"], sorted(start["headers"]), body


def both(query, headers, pieces):
    """Return the answers of the route that reads at once and of the one that does not."""
    given = [
        (b"host", b"there"),
        (b"content-length", b"%d" % len(b"".join(p or b"" for p in pieces))),
    ]
    return [
        asyncio.run(answer(app, query, [*given, *headers], pieces)) for app in (STRAIGHT, USUAL)
    ]


@given(
    st.lists(st.sampled_from(QUERIES), max_size=3).map(b"&".join),
    st.lists(st.sampled_from(HEADERS), max_size=3),
    st.booleans(),
    st.sampled_from(BODIES),
    st.integers(0, 40),
)
@settings(max_examples=num_cases(300), deadline=None)
def test_whatever_is_sent_the_answer_is_that_of_fastapi(query, headers, is_json, body, cut):
    headers = [*headers, (b"content-type", JSON)] if is_json else headers
    straight, usual = both(query, headers, [body[:cut], body[cut:]])
    assert straight == usual


@pytest.mark.parametrize("body", BODIES)
def test_every_body_alone_is_answered_alike(body):
    straight, usual = both(b"wait=3", [(b"content-type", JSON)], [body])
    assert straight == usual


@pytest.mark.parametrize("query", [*QUERIES, b"wait=3&wait=4", b"wait=3&include=a"])
def test_every_query_alone_is_answered_alike(query):
    straight, usual = both(query, [(b"content-type", JSON)], [BODIES[0]])
    assert straight == usual


@pytest.mark.parametrize("header", [*HEADERS, (b"content-type", b"text/yaml")])
def test_every_header_alone_is_answered_alike(header):
    more = [] if header[0] == b"content-type" else [(b"content-type", JSON)]
    straight, usual = both(b"", [header, *more], [BODIES[0]])
    assert straight == usual


@pytest.mark.parametrize("app", [STRAIGHT, USUAL])
def test_a_client_that_leaves_before_its_body_is_there_is_no_surprise(app):
    headers = [(b"content-type", JSON), (b"content-length", b"99")]
    status, _, _ = asyncio.run(answer(app, b"", headers, [b'{"name"', None]))
    assert status == 400


def test_the_usual_request_is_read_at_once(monkeypatch):
    async def refuse(*_):
        pytest.fail("it was read by FastAPI")

    monkeypatch.setattr(StrictRoute, "handle", refuse)
    headers = [(b"content-type", JSON), (b"idempotency-key", b"k")]
    status, _, body = asyncio.run(answer(STRAIGHT, b"wait=3", headers, [BODIES[0]]))
    assert (status, json.loads(body)["wait"]) == (202, 3.0)


def test_plans_are_requested_in_that_way():
    [create] = [route for route in plans.router.routes if route.operation_id == "createPlan"]
    assert create.reads_at_once
