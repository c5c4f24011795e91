"""What is changed is written down, with who did it; secrets are written nowhere."""

import asyncio
import json
import logging
import subprocess
import sys
from datetime import UTC, datetime

import pytest

from service.app import create_app
from service.jobs.store.sql.database import open_engine
from service.security.audit import Audit
from service.security.keys import KeyStore
from service.security.scopes import Scope
from service.settings import Settings
from tests.service.conftest import BLOCK_SCENE, TestClient


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    settings = Settings(engine="inline", data_dir=tmp_path_factory.mktemp("audit"), auth="keys")
    with TestClient(create_app(settings)) as client:
        yield client


@pytest.fixture(scope="module")
def key(guarded):
    """A key for plans, called `ci`."""
    engine = open_engine(guarded.app.state.settings.url)
    made = KeyStore(engine).create("ci", [Scope.PLAN], datetime.now(UTC)).text
    engine.dispose()
    guarded.portal.call(guarded.app.state.callers.keys.read)
    return made


@pytest.fixture
def lines(caplog):
    """The lines of the audit since it was asked last."""
    caplog.set_level(logging.DEBUG)

    def take():
        found = [record for record in caplog.records if record.name == "wayproof.audit"]
        caplog.clear()
        return [json.loads(record.getMessage()) for record in found]

    return take


def test_a_change_is_written_with_who_what_and_how_it_ended(guarded, key, lines):
    headers = {"Authorization": f"Bearer {key}", "X-Request-ID": "r1"}
    answer = guarded.post("/v1/scenes", json=BLOCK_SCENE, headers=headers)
    path = f"/v1/scenes/{answer.json()['id']}"
    assert lines() == [
        {
            "caller": "ci", "operation": "createScene", "method": "POST", "path": "/v1/scenes",
            "resource": path, "status": 201, "request_id": "r1",
        }
    ]  # fmt: skip
    guarded.delete(path, headers=headers)
    guarded.delete(path, headers=headers)
    shown = [(line["operation"], line["resource"], line["status"]) for line in lines()]
    identifier = answer.json()["id"]
    assert shown == [("deleteScene", identifier, 204), ("deleteScene", identifier, 404)]


def test_what_was_not_let_in_is_written(guarded, key, lines):
    headers = {"Authorization": f"Bearer {key}"}
    assert guarded.get("/v1/plans").status_code == 401
    assert guarded.post("/v1/executions/x/cancel", headers=headers).status_code == 403
    assert [(line["caller"], line["method"], line["status"]) for line in lines()] == [
        (None, "GET", 401),
        ("ci", "POST", 403),
    ]


def test_what_changes_nothing_is_not_written(client, scene, lines):
    client.get("/v1/plans")
    client.get("/v1/plans/none")
    request = {"group": "arm", "configurations": [[0.0] * 6]}
    assert client.post(f"/v1/scenes/{scene}/check", json=request).status_code == 200
    assert lines() == []


def test_without_keys_there_is_no_caller(client, lines):
    client.post("/v1/plans/none/cancel")
    (line,) = lines()
    assert (line["caller"], line["operation"], line["resource"]) == (None, "cancelPlan", "none")


def test_a_path_makes_no_lines_of_its_own(client, caplog, lines):
    client.post("/v1/plans/a%0Ab%22%2C/cancel")
    messages = [r.getMessage() for r in caplog.records if r.name == "wayproof.audit"]
    assert [message.count("\n") for message in messages] == [0]
    assert lines()[0]["resource"] == 'a\nb",'
    client.post("/" + "x" * 5000)
    assert len(lines()[0]["path"]) <= 200


def test_a_key_in_an_address_is_not_written(guarded, key, lines):
    guarded.post(f"/v1/plans/{key}/cancel", headers={"Authorization": f"Bearer {key}"})
    (line,) = lines()
    assert line["resource"] == f"{key[:16]}..."
    assert line["path"] == f"/v1/plans/{key[:16]}.../cancel"


@pytest.mark.parametrize("fault", [RuntimeError, asyncio.CancelledError])
def test_what_has_no_answer_is_written_too(lines, fault):
    async def break_off(scope, receive, send):
        raise fault

    scope = {"type": "http", "method": "POST", "path": "/v1/plans"}
    with pytest.raises(fault):
        asyncio.run(Audit(break_off)(scope, None, None))
    (line,) = lines()
    assert (line["path"], line["status"]) == ("/v1/plans", 500 if fault is RuntimeError else None)


def test_no_secret_is_in_any_log_or_answer(guarded, key, caplog):
    """Nor one that is none, nor the digest of one: at any level, of any library."""
    caplog.set_level(logging.DEBUG)
    wrong = "wp_000000000000_" + "Q" * 43
    secrets = [key[16:], "Q" * 43]
    texts = []
    for text in (key, wrong):
        for header in (f"Bearer {text}", f"Basic {text}", text):
            headers = {"Authorization": header}
            for method, path in (
                ("GET", "/v1/plans"), ("POST", "/v1/scenes"), ("GET", "/metrics"),
                ("POST", "/v1/executions"), ("GET", "/v2"),
            ):  # fmt: skip
                answer = guarded.request(method, path, headers=headers)
                texts += [answer.text, str(answer.headers)]
    guarded.portal.call(guarded.app.state.callers.keys.read)
    digests = [each.digest for each in guarded.app.state.callers.keys._keys.values()]
    assert digests
    texts += [logging.Formatter().format(record) for record in caplog.records]
    texts += [str(record.__dict__) for record in caplog.records]
    assert any("wayproof.audit" in text for text in texts)
    for text in texts:
        assert not [secret for secret in [*secrets, *digests] if secret in text]


def test_the_server_writes_the_audit_whatever_its_level():
    code = """
import logging
from service.telemetry.logs import LogTerms, configure_logs
configure_logs(LogTerms("json", "error"))
logging.getLogger("wayproof.audit").info("%s", '{"caller": "ci", "status": 201}')
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    line = json.loads(done.stderr)
    assert (line["event"], line["caller"], line["status"]) == ("audit", "ci", 201)
