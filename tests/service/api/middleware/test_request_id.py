"""Every answer carries the id of its request, and so does what is logged about it."""

import asyncio
import json
import re

import pytest
from fastapi.testclient import TestClient

from service.api import operations
from service.api.middleware.request_id import HEADER, RequestId, request_id
from service.telemetry.logs import LineFormatter

MADE = re.compile(r"[0-9a-f]{32}")


@pytest.mark.parametrize("given", ["a", "A.b_c-9", "x" * 64])
def test_a_sane_id_is_taken(client, given):
    assert client.get("/healthz", headers={HEADER: given}).headers[HEADER] == given


@pytest.mark.parametrize("given", ["", "x" * 65, "a b", "a,b", "a\u00e4", 'a"b', "a\tb"])
def test_another_one_is_made_for_what_is_not(client, given):
    answer = client.get("/healthz", headers={HEADER: given.encode("latin-1")})
    assert MADE.fullmatch(answer.headers[HEADER])


def test_made_ids_differ(client):
    assert client.get("/healthz").headers[HEADER] != client.get("/healthz").headers[HEADER]


@pytest.mark.parametrize(
    ("method", "path", "more", "status"),
    [
        ("GET", "/v1/scenes", {}, 200),
        ("GET", "/v1/plans/pln_nothing", {}, 404),
        ("PUT", "/v1/plans", {}, 405),
        ("POST", "/v1/plans", {"json": {}}, 422),
        ("POST", "/v1/plans", {"content": b"x" * 5_000_000}, 413),
        ("GET", "/v1/scenes", {"headers": {"host": "elsewhere"}}, 400),
        ("GET", "/v1/scenes", {"headers": {"origin": "http://elsewhere"}}, 403),
    ],
)
def test_problems_carry_it_too(client, method, path, more, status):
    headers = {HEADER: "mine", **more.pop("headers", {})}
    answer = client.request(method, path, headers=headers, **more)
    assert answer.status_code == status
    assert answer.headers[HEADER] == "mine"


def test_an_unexpected_fault_carries_it_and_is_logged_with_it(app, client, monkeypatch, caplog):
    monkeypatch.setattr(caplog.handler, "formatter", LineFormatter("json"))

    def fail():
        raise ZeroDivisionError

    monkeypatch.setattr(operations, "versions", fail)
    quiet = TestClient(app, raise_server_exceptions=False)
    answer = quiet.get("/healthz", headers={HEADER: "mine"})
    assert answer.status_code == 500
    assert answer.headers[HEADER] == "mine"
    lines = [json.loads(line) for line in caplog.text.splitlines()]
    (line,) = [line for line in lines if line["event"] == "unexpected error"]
    assert line["request_id"] == "mine"


def test_requests_at_once_keep_their_own():
    seen = {}

    async def app(scope, receive, send):
        before = request_id()
        await asyncio.sleep(0)
        seen[before] = request_id()
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def ask(name):
        sent = []
        scope = {"type": "http", "headers": [(b"x-request-id", name.encode())]}

        async def send(message):
            sent.append(message)

        await RequestId(app)(scope, None, send)
        return dict(sent[0]["headers"])[b"x-request-id"].decode()

    async def story():
        return await asyncio.gather(*(asyncio.create_task(ask(name)) for name in names))

    names = [f"n{i}" for i in range(5)]
    assert asyncio.run(story()) == names
    assert seen == {name: name for name in names}
