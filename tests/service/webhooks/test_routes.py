"""Webhooks over HTTP: registered, listed, shown without their secret, told, deleted."""

import json
import uuid
import warnings
from datetime import UTC, datetime, timedelta

import pytest
from standardwebhooks import Webhook

from service.app import create_app
from service.jobs.store.sql.database import open_engine
from service.security.keys import KeyStore
from service.security.scopes import Scope
from service.settings import Settings
from tests.profiles import only_campaign
from tests.service.pages import walk
from tests.service.servers import until
from tests.service.webhooks.receiver import receiver

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient

PUBLIC = "https://93.184.216.34/hook"


@pytest.fixture(scope="module")
def open_client(tmp_path_factory):
    """A client of a server whose webhooks may lead to this machine."""
    folder = tmp_path_factory.mktemp("webhooks")
    chosen = Settings(engine="inline", data_dir=folder, webhook_private_addresses=True)
    with TestClient(create_app(chosen)) as running:
        yield running


def test_a_webhook_is_registered_and_its_secret_told_once(client):
    made = client.post("/v1/webhooks", json={"url": PUBLIC})
    assert made.status_code == 201
    told = made.json()
    assert made.headers["location"] == f"/v1/webhooks/{told['id']}"
    secret = told.pop("secret")
    assert secret.startswith("whsec_")
    assert told["events"] == ["plan.finished", "regions.finished", "execution.finished"]
    assert client.get(f"/v1/webhooks/{told['id']}").json() == told
    assert secret not in client.get("/v1/webhooks").text
    assert told in walk(client, "/v1/webhooks", limit=1)
    assert client.delete(f"/v1/webhooks/{told['id']}").status_code == 204
    for ask in (client.get, client.delete):
        assert ask(f"/v1/webhooks/{told['id']}").status_code == 404
    assert client.post(f"/v1/webhooks/{told['id']}/enable").status_code == 404


@pytest.mark.parametrize(
    "url",
    [
        "ftp://example.org/",
        "file:///etc/passwd",
        "https://",
        "http://a b/",
        "https://user:word@example.org/",
        "https://example.org:99999/",
        "http://[::1",
        "x" * 2001,
        "",
    ],
)
def test_what_is_no_address_of_the_web_is_refused(client, url):
    told = client.post("/v1/webhooks", json={"url": url})
    assert (told.status_code, told.json()["code"]) == (422, "request_invalid")
    assert told.json()["errors"][0]["pointer"] == "/url"


@pytest.mark.parametrize("host", ["127.0.0.1:8470", "localhost", "10.0.0.1", "[::1]", "0"])
def test_an_address_that_is_not_public_is_refused(client, host):
    told = client.post("/v1/webhooks", json={"url": f"http://{host}/"})
    assert (told.status_code, told.json()["code"]) == (422, "address_not_allowed")
    assert told.json()["errors"][0]["pointer"] == "/url"


@pytest.mark.parametrize("events", [[], ["plan.ended"], "plan.finished"])
def test_types_of_messages_are_known(client, events):
    told = client.post("/v1/webhooks", json={"url": PUBLIC, "events": events})
    assert told.status_code == 422


@only_campaign("7 s")
def test_the_end_of_a_batch_of_plans_is_told_plan_by_plan(open_client):
    robots = [{"name": "arm", "model": "ur5e", "positions": "home"}]
    scene = open_client.post("/v1/scenes", json={"robots": robots}).json()["id"]
    goal = {"type": "configuration", "name": "ready"}
    one = {"scene": scene, "group": "arm", "goal": goal, "search": {"allowed_planning_time": 60.0}}
    away = {"type": "pose", "poses": [{"position": [9, 0, 0]}]}
    body = {"problems": [one, {**one, "goal": away, "ik": {"max_trials": 5}}]}
    with receiver() as target:
        target.answers = [503]
        path = f"/{uuid.uuid4().hex}"
        hook = open_client.post("/v1/webhooks", json={"url": target.url + path}).json()
        batch = open_client.post("/v1/plans/batch", json=body).json()
        posts = target.wait_for(3)
        told = {headers["webhook-id"]: json.loads(body) for headers, body in posts}
        ends = {message["data"]["id"]: message["data"]["state"] for message in told.values()}
        first, second = batch["plans"]
        assert ends == {first: "succeeded", second: "failed"}
        assert {message["data"]["batch"] for message in told.values()} == {batch["id"]}
        for headers, content in posts:
            Webhook(hook["secret"]).verify(content, headers)
        address = f"/v1/webhooks/{hook['id']}"
        assert until(lambda: open_client.get(address).json()["failing_since"] is None)
        open_client.delete(address)


def test_no_client_is_told_the_secret_of_another_ones_webhook(tmp_path):
    settings = Settings(engine="inline", data_dir=tmp_path, auth="keys")
    request = {"url": PUBLIC, "events": ["plan.finished"]}
    with TestClient(create_app(settings)) as running:
        keys = KeyStore(engine := open_engine(settings.url))
        texts = {name: keys.create(name, [Scope.ADMIN], datetime.now(UTC)).text for name in "ab"}
        texts["a again"] = keys.rotate("a", datetime.now(UTC), timedelta(hours=1)).text
        engine.dispose()
        running.portal.call(running.app.state.callers.keys.read)
        told = {}
        for name, text in texts.items():
            headers = {"Authorization": f"Bearer {text}", "Idempotency-Key": "deploy"}
            told[name] = running.post("/v1/webhooks", json=request, headers=headers).json()
    assert told["a again"] == told["a"]
    assert told["b"]["id"] != told["a"]["id"]
    assert told["b"]["secret"] != told["a"]["secret"]
