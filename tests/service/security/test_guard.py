"""A server with keys: who has none learns nothing, and each key does what its scopes say."""

import asyncio
import threading
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import anyio
import pytest
from sqlalchemy.exc import OperationalError
from starlette.testclient import WebSocketDenialResponse

from service.app import create_app
from service.jobs.store.sql.database import open_engine
from service.security.guard import Guard
from service.security.key_ring import KeyRing
from service.security.keys import ApiKey, KeyStore
from service.security.scopes import Scope
from service.settings import Settings
from tests.service.api_routes import api_routes
from tests.service.conftest import BLOCK_SCENE, TestClient


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    """A server with keys."""
    folder = tmp_path_factory.mktemp("guarded")
    settings = Settings(engine="inline", data_dir=folder, auth="keys")
    with TestClient(create_app(settings)) as client:
        yield client


@pytest.fixture(scope="module")
def store(guarded):
    engine = open_engine(guarded.app.state.settings.url)
    yield KeyStore(engine)
    engine.dispose()


@pytest.fixture(scope="module")
def keys(guarded, store):
    """A key of each scope."""
    made = {
        str(scope): store.create(str(scope), [scope], datetime.now(UTC)).text for scope in Scope
    }
    guarded.portal.call(guarded.app.state.callers.keys.read)
    return made


def bearer(text):
    return {"Authorization": f"Bearer {text}"}


def requests():
    """Every operation, with names that nothing has."""
    for route in api_routes():
        path = route.path_format.replace("{name}.svg", "jerk.svg")
        yield from ((method, path.replace("{", "").replace("}", "")) for method in route.methods)


PUBLIC = {("GET", "/healthz"), ("GET", "/readyz")}


@pytest.mark.parametrize(("method", "path"), sorted(set(requests()) - PUBLIC))
def test_nothing_is_answered_without_a_key(guarded, method, path):
    for headers in ({}, bearer("wp_000000000000_" + "A" * 43)):
        answer = guarded.request(method, path, headers=headers, content=b"{" * 100)
        assert (answer.status_code, answer.json()["code"]) == (401, "unauthorized")
        assert answer.headers["www-authenticate"].startswith("Bearer")
        assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("method", ["HEAD", "OPTIONS", "TRACE", "PUT", "get", "X"])
def test_nor_is_another_method(guarded, method):
    for path in sorted({path for _, path in set(requests()) - PUBLIC}):
        answer = guarded.request(method, path)
        assert (answer.status_code, len(answer.headers["www-authenticate"])) == (401, 23), path


def test_unknown_paths_are_not_told_from_others(guarded):
    assert guarded.get("/v1/nothing").status_code == 401
    assert guarded.post("/v2").status_code == 401


ASSETS = ["/docs/swagger-ui-bundle.js", "/docs/swagger-ui.css", "/docs/favicon.png"]


@pytest.mark.parametrize("path", ["/healthz", "/readyz", "/docs", "/openapi.json", *ASSETS])
def test_health_and_documentation_are_open(guarded, path):
    assert guarded.get(path).status_code == 200


def test_the_document_of_a_server_with_keys_asks_for_them(guarded):
    operation = guarded.get("/openapi.json").json()["paths"]["/v1/plans"]["post"]
    assert operation["security"] == [{"key": ["plan"]}]


@pytest.mark.parametrize(
    "headers",
    [
        lambda key: {"Authorization": key},
        lambda key: {"Authorization": f"Basic {key}"},
        lambda key: {"Authorization": f"Bearer {key}x"},
        lambda key: {"Authorization": f"Bearer {key}, Bearer {key}"},
        lambda key: {"X-API-Key": key},
        lambda key: [("Authorization", f"Bearer {key}"), ("Authorization", f"Bearer {key}")],
    ],
)
def test_a_key_comes_in_one_way(guarded, keys, headers):
    assert guarded.get("/v1/plans", headers=headers(keys["admin"])).status_code == 401
    assert guarded.get(f"/v1/plans?key={keys['admin']}").status_code == 401


@pytest.mark.parametrize(
    ("method", "path", "needed"),
    [
        ("GET", "/v1/plans", "read"),
        ("GET", "/v1/executions", "read"),
        ("POST", "/v1/plans", "plan"),
        ("POST", "/v1/trajectories/retime", "plan"),
        ("POST", "/v1/scenes", "plan"),
        ("PATCH", "/v1/scenes/x", "plan"),
        ("DELETE", "/v1/scenes/x", "plan"),
        ("POST", "/v1/executions", "execute"),
        ("POST", "/v1/executions/x/speed", "execute"),
        ("DELETE", "/v1/executions/x", "execute"),
        ("POST", "/v1/plans/batch", "plan"),
        ("GET", "/v1/batches/x", "read"),
        ("GET", "/v1/webhooks", "admin"),
        ("POST", "/v1/webhooks/x/enable", "admin"),
        ("GET", "/metrics", "admin"),
    ],
)
def test_a_key_does_what_its_scopes_say(guarded, keys, method, path, needed):
    for scope, key in keys.items():
        answer = guarded.request(method, path, headers=bearer(key))
        if scope in {needed, "admin"}:
            assert answer.status_code not in {401, 403}, (scope, answer.text)
            continue
        problem = answer.json()
        assert (answer.status_code, problem["code"]) == (403, "scope_missing")
        assert problem["evidence"] == {"needed": needed, "scopes": [scope]}
        assert f'scope="{needed}"' in answer.headers["www-authenticate"]


@pytest.mark.parametrize(
    ("method", "path", "scope"),
    [
        ("GET", "/metrics%0A", "read"),
        ("POST", "/v1/executions%0A", "plan"),
        ("POST", "/v1/%65xecutions", "plan"),
        ("POST", "/v1/executions/x/cancel%0A", "plan"),
        ("HEAD", "/metrics", "read"),
    ],
)
def test_no_spelling_of_a_path_needs_less(guarded, keys, method, path, scope):
    answer = guarded.request(method, path, headers=bearer(keys[scope]))
    assert answer.status_code == 403


@pytest.mark.parametrize("path", ["/docs/../v1/plans", "/docs/%2e%2e/v1/plans", "/docs/..%2fv1"])
def test_nothing_is_behind_the_documentation(guarded, path):
    answer = guarded.get(path)
    assert answer.status_code in {401, 404, 422}
    assert answer.headers["content-type"] == "application/problem+json"


def test_nothing_of_a_body_is_read_without_a_key():
    """Nor of one that comes with a key of another scope."""

    def ask(key):
        sent = []

        async def find(text):
            return key

        async def run():
            settings = Settings(auth="keys")
            scope = {"type": "http", "method": "POST", "path": "/v1/scenes", "headers": []}
            scope["headers"] = [(b"authorization", b"Bearer x")] if key else []

            async def receive():
                pytest.fail("the body is read")

            async def send(message):
                sent.append(message)

            ring = SimpleNamespace(find=find)
            await Guard(None, settings, lambda: ring)(scope, receive, send)

        asyncio.run(run())
        return sent[0]["status"]

    assert ask(None) == 401
    assert ask(ApiKey("a", "a", frozenset({Scope.READ}), "", datetime.now(UTC))) == 403


def test_a_revoked_key_is_refused_once_the_keys_are_read_again(guarded, store):
    ring = guarded.app.state.callers.keys
    key = store.create("leaver", [Scope.READ], datetime.now(UTC)).text
    guarded.portal.call(ring.read)
    assert guarded.get("/v1/plans", headers=bearer(key)).status_code == 200
    store.revoke("leaver", datetime.now(UTC))
    guarded.portal.call(ring.read)
    assert guarded.get("/v1/plans", headers=bearer(key)).status_code == 401


def test_an_expired_key_is_refused(guarded, store):
    past = datetime.now(UTC) - timedelta(days=2)
    key = store.create("old", [Scope.READ], past, past + timedelta(days=1)).text
    guarded.portal.call(guarded.app.state.callers.keys.read)
    assert guarded.get("/v1/plans", headers=bearer(key)).status_code == 401


class Following:
    """A stream of three events as the guard lets it through, and what is done between them."""

    def __init__(self, between, kind=b"text/event-stream; charset=utf-8"):
        self.between, self.kind, self.sent, self.has_ended = between, kind, [], False

    async def __call__(self, scope, receive, send):
        headers = [(b"content-type", self.kind)]
        try:
            async with anyio.create_task_group():  # as what streams events has one
                await send({"type": "http.response.start", "status": 200, "headers": headers})
                for i in range(3):
                    body = {"type": "http.response.body", "body": b"%d" % i, "more_body": i < 2}
                    await send(body)
                    if i == 0:
                        await self.between()
        finally:
            self.has_ended = True

    def follow(self, ring, text):
        async def run():
            await ring.read()
            headers = [(b"authorization", f"Bearer {text}".encode())]
            scope = {"type": "http", "method": "GET", "path": "/v1/plans/x/events"}

            async def send(message):
                self.sent.append(message)

            await Guard(self, Settings(auth="keys"), lambda: ring)(
                scope | {"headers": headers}, None, send
            )
            await ring.close()

        asyncio.run(run())
        return [(part["body"], part["more_body"]) for part in self.sent[1:]]


@pytest.mark.parametrize("kind", [b"text/event-stream; charset=utf-8", b"application/json"])
@pytest.mark.parametrize("end", ["revoked", "expired", "not"])
def test_a_stream_ends_with_its_key_and_a_plain_answer_does_not(tmp_path, end, kind):
    keys = Ring(tmp_path)
    keys.now = 10.0
    lifetime = timedelta(days=1 if end != "expired" else -1)
    until = datetime.now(UTC) + timedelta(days=1)
    new = keys.store.create("a", [Scope.READ], datetime.now(UTC), until)

    async def between():
        if end == "revoked":
            keys.store.revoke("a", datetime.now(UTC))
            keys.now += 1.0
            keys.ring.is_good(new.key)  # an event that finds the keys old has them read again
            await keys.ring._reading
        if end == "expired":
            known = keys.ring._keys
            known[new.key.id] = replace(new.key, expires_at=datetime.now(UTC) + lifetime)

    stream = Following(between, kind)
    got = stream.follow(keys.ring, new.text)
    assert stream.has_ended
    if end == "not" or kind == b"application/json":
        assert got == [(b"0", True), (b"1", True), (b"2", False)]
    else:
        assert got == [(b"0", True), (b"", False)]


@pytest.mark.parametrize("end", ["revoked", "not"])
def test_a_websocket_ends_with_its_key(tmp_path, end):
    keys = Ring(tmp_path)
    keys.now = 10.0
    new = keys.store.create("a", [Scope.READ], datetime.now(UTC))
    sent = []

    async def app(scope, receive, send):
        await send({"type": "websocket.accept"})
        await send({"type": "websocket.send", "text": "0"})
        if end == "revoked":
            keys.store.revoke("a", datetime.now(UTC))
            keys.now += 1.0
            keys.ring.is_good(new.key)
            await keys.ring._reading
        await send({"type": "websocket.send", "text": "1"})

    async def run():
        await keys.ring.read()
        headers = [(b"authorization", f"Bearer {new.text}".encode())]
        scope = {"type": "websocket", "path": "/v1/scenes/x/state/ws", "headers": headers}

        async def send(message):
            sent.append(message)

        await Guard(app, Settings(auth="keys"), lambda: keys.ring)(scope, None, send)
        await keys.ring.close()

    asyncio.run(run())
    texts = [message["text"] for message in sent if message["type"] == "websocket.send"]
    if end == "revoked":
        assert texts == ["0"]
        assert sent[-1] == {"type": "websocket.close", "code": 1008}
    else:
        assert texts == ["0", "1"]


def test_a_websocket_needs_a_key_as_well(guarded, keys):
    scene = guarded.post("/v1/scenes", json=BLOCK_SCENE, headers=bearer(keys["plan"])).json()["id"]
    path = f"/v1/scenes/{scene}/state/ws"
    for headers, status in (({}, 401), (bearer(keys["plan"]), 403)):
        with (
            pytest.raises(WebSocketDenialResponse) as refused,
            guarded.websocket_connect(path, headers=headers),
        ):
            pytest.fail("it was let in")
        assert refused.value.status_code == status
    with guarded.websocket_connect(path, headers=bearer(keys["read"])) as socket:
        assert socket.receive_json()["data"]["scene"] == scene


def test_a_stream_does_not_wait_for_a_database_that_hangs(tmp_path):
    keys = Ring(tmp_path)
    new = keys.store.create("a", [Scope.READ], datetime.now(UTC))
    release, real = threading.Event(), keys.all

    async def between():
        keys.now += 100.0
        keys.all = lambda: (release.wait(60), real())[1]

    stream = Following(between)
    try:
        assert len(stream.follow(keys.ring, new.text)) == 3
        assert not release.is_set()
    finally:
        release.set()


def test_a_whole_way_with_keys(guarded, keys):
    scene = guarded.post("/v1/scenes", json=BLOCK_SCENE, headers=bearer(keys["plan"])).json()
    path = f"/v1/scenes/{scene['id']}"
    assert guarded.get(path, headers=bearer(keys["plan"])).status_code == 403
    assert guarded.get(path, headers=bearer(keys["read"])).json()["name"] == "block"


class Ring:
    """A ring of keys whose clock and database are the test's."""

    def __init__(self, tmp_path):
        self.engine = open_engine(f"sqlite:///{tmp_path / 'keys.sqlite'}")
        self.store = KeyStore(self.engine)
        self.store.open()
        self.now = 0.0
        self.num_reads = 0
        self.ring = KeyRing(self, lambda: self.now)
        self.fault = None

    def all(self):
        self.num_reads += 1
        if self.fault is not None:
            raise self.fault
        return self.store.all()

    def find(self, *texts):
        """What is found, by one loop after the other."""

        async def run():
            try:
                return [await self.ring.find(text) for text in texts]
            finally:
                await self.ring.close()

        return asyncio.run(run())


def test_keys_are_read_once_a_second_whatever_is_asked(tmp_path):
    keys = Ring(tmp_path)
    keys.now = 10.0
    new = keys.store.create("a", [Scope.READ], datetime.now(UTC))
    assert keys.find(new.text, *["wp_000000000000_" + "A" * 43] * 50) == [new.key] + [None] * 50
    assert keys.num_reads == 1
    keys.store.revoke("a", datetime.now(UTC))
    keys.now = 10.9
    assert keys.find(new.text) == [new.key]
    keys.now = 11.0
    assert keys.find(new.text) == [None]
    assert keys.num_reads == 2


def test_keys_hold_while_the_database_is_away(tmp_path, caplog):
    keys = Ring(tmp_path)
    keys.now = 10.0
    new = keys.store.create("a", [Scope.READ], datetime.now(UTC))
    assert keys.find(new.text) == [new.key]
    keys.fault = OperationalError("select", {}, Exception("locked"))
    keys.now = 12.0
    assert keys.find(new.text, new.text) == [new.key] * 2
    assert keys.num_reads == 2
    assert "those that were read last hold" in caplog.text


def test_a_request_does_not_wait_for_a_database_that_hangs(tmp_path):
    keys = Ring(tmp_path)
    keys.now = 10.0
    new = keys.store.create("a", [Scope.READ], datetime.now(UTC))
    assert keys.find(new.text) == [new.key]
    release, real = threading.Event(), keys.all
    keys.all = lambda: (release.wait(60), real())[1]
    keys.now = 12.0
    try:
        assert keys.find(new.text) == [new.key]
    finally:
        release.set()
