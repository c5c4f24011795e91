"""With the database locked by another program, what needs no write is answered, the rest is 503."""

import pytest

from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from tests.service.jobs.databases import locked


@pytest.fixture
def held(app, settings, client, monkeypatch):
    """The write lock is another's; new jobs are refused soon."""
    dispatcher = app.state.jobs._dispatcher
    monkeypatch.setattr(dispatcher, "_timeouts", DatabaseTimeouts(record=0.05))
    with locked(settings.data_dir / "wayproof.sqlite"):
        yield


READS = ["/healthz", "/readyz", "/metrics", "/v1/plans", "/v1/scenes", "/v1/executions"]


def test_what_is_read_is_answered(client, solved, scene, held):
    own = [f"/v1/plans/{solved['id']}", f"/v1/plans/{solved['id']}/events", f"/v1/scenes/{scene}"]
    for path in READS + own:
        assert client.get(path).status_code == 200, path
    assert "event: finished" in client.get(own[1]).text


def test_a_plan_that_cannot_be_recorded_is_refused_and_never_made(client, scene, request):
    before = client.get("/v1/plans?limit=1").json()["items"]
    asked = {"scene": scene, "group": "arm", "goal": {"type": "configuration", "name": "home"}}
    request.getfixturevalue("held")
    answer = client.post("/v1/plans", json=asked, headers={"Idempotency-Key": "locked"})
    assert (answer.status_code, answer.json()["code"]) == (503, "database_unavailable")
    assert int(answer.headers["Retry-After"]) >= 1
    assert client.get("/v1/plans?limit=1").json()["items"] == before


def test_and_not_made_later_either(client, scene):
    """The same key after the lock is gone makes a new job: the refused one is nowhere."""
    asked = {"scene": scene, "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    answer = client.post("/v1/plans", json=asked, headers={"Idempotency-Key": "locked"})
    assert answer.status_code == 202
    client.post(f"/v1/plans/{answer.json()['id']}/cancel")
