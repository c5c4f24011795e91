"""Every answer tells browsers what not to do with it, and which pages may read it."""

import asyncio

import pytest

from service.app import create_app
from service.settings import Settings
from tests.service.conftest import TestClient

UI = "https://ui.example.org"


def directives(answer):
    policy = answer.headers["content-security-policy"]
    return {part.split()[0]: part.split()[1:] for part in policy.split(";")}


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/v1/plans", 200),
        ("GET", "/docs", 200),
        ("GET", "/healthz", 200),
        ("GET", "/v1/plans/none", 404),
        ("PUT", "/v1/plans", 405),
        ("POST", "/v1/plans", 422),
        ("GET", "/", 200),
    ],
)
def test_every_answer_has_them(client, method, path, status):
    answer = client.request(method, path)
    assert answer.status_code == status
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert answer.headers["x-frame-options"] == "DENY"
    assert directives(answer)["frame-ancestors"] == ["'none'"]


def test_so_have_refusals_before_any_route_and_unexpected_errors(client, app, monkeypatch):
    stranger = client.get("/v1/plans", headers={"Host": "evil.example"})
    assert stranger.json()["code"] == "host_not_allowed"
    jobs = app.state.jobs
    monkeypatch.setattr(type(jobs), "page", lambda *_, **__: 1 / 0)
    quiet = TestClient(app, raise_server_exceptions=False)
    broken = quiet.get("/v1/plans")
    assert broken.status_code == 500
    for answer in (stranger, broken):
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert directives(answer)["frame-ancestors"] == ["'none'"]


def test_so_has_what_the_end_of_the_server_cuts_off(client, app, monkeypatch):
    async def canceled(*_, **__):
        raise asyncio.CancelledError

    monkeypatch.setattr(type(app.state.jobs), "page", canceled)
    monkeypatch.setattr(app.state, "is_stopping", True)
    answer = client.get("/v1/plans")
    assert (answer.status_code, answer.json()["code"]) == (503, "server_stopping")
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_pages_load_nothing_from_elsewhere(client, solved):
    replay = client.get(f"/v1/plans/{solved['id']}/replay.html")
    assert replay.headers["content-type"].startswith("text/html")
    for answer in (replay, client.get("/docs")):
        for name, sources in directives(answer).items():
            assert not [each for each in sources if "." in each or "//" in each or each == "*"], (
                name
            )
        assert "default-src" in directives(answer)
        assert directives(answer)["base-uri"] == ["'none'"]
    # A replay shows names that a client chose: it may ask no server, not even this one.
    sources = directives(replay)
    assert set(sources["default-src"]) == {"'unsafe-inline'", "'unsafe-eval'", "data:", "blob:"}
    assert not {"connect-src", "script-src", "frame-src"} & set(sources)


def test_what_is_no_page_runs_no_scripts(client, solved):
    drawing = client.get(f"/v1/plans/{solved['id']}/plots/velocity.svg")
    assert drawing.headers["content-type"] == "image/svg+xml"
    for answer in (drawing, client.get("/v1/plans")):
        rules = directives(answer)
        assert rules["default-src"] == ["'none'"]
        assert "script-src" not in rules
        assert rules["sandbox"] == []


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    """A server that pages of another origin may ask, with keys."""
    folder = tmp_path_factory.mktemp("shared")
    settings = Settings(engine="inline", data_dir=folder, auth="keys", allowed_origins=[UI])
    with TestClient(create_app(settings)) as client:
        yield client


def preflight(client, origin, method="POST", headers="authorization, content-type"):
    asked = {"Origin": origin, "Access-Control-Request-Method": method}
    return client.options("/v1/plans", headers=asked | {"Access-Control-Request-Headers": headers})


def test_named_pages_may_send_a_key_and_read_the_answer(shared):
    answer = preflight(shared, UI)
    assert answer.status_code == 200
    assert answer.headers["access-control-allow-origin"] == UI
    assert "authorization" in answer.headers["access-control-allow-headers"].lower()
    refused = shared.get("/v1/plans", headers={"Origin": UI})
    assert refused.status_code == 401
    assert refused.headers["access-control-allow-origin"] == UI
    assert "X-Request-ID" in refused.headers["access-control-expose-headers"]
    assert "access-control-allow-credentials" not in refused.headers


def test_other_pages_may_not(shared, client):
    for server in (shared, client):
        answer = preflight(server, "https://evil.example")
        assert (answer.status_code, answer.json()["code"]) == (403, "origin_not_allowed")
        assert "access-control-allow-origin" not in answer.headers


def test_no_page_may_send_what_no_operation_reads(shared):
    assert preflight(shared, UI, headers="x-evil").status_code == 400
    assert preflight(shared, UI, method="PUT").status_code == 400
