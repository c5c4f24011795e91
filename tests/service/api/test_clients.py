"""Jobs know who requests them and what goes first; what says so over HTTP."""

import sqlite3
from contextlib import closing

import pytest

from service.api.dependencies import CALLER, client_of

READY = {"type": "configuration", "name": "ready"}


@pytest.mark.parametrize(
    ("scope", "client"),
    [
        ({CALLER: "cell-3", "client": ("10.0.0.7", 4711)}, "key cell-3"),
        ({"client": ("10.0.0.7", 4711)}, "address 10.0.0.7"),
        ({"client": ("10.0.0.7", 4712)}, "address 10.0.0.7"),
        ({"client": None}, "address unknown"),
        ({}, "address unknown"),
    ],
)
def test_a_client_is_a_key_or_else_an_address(scope, client):
    assert client_of(scope) == client


def row(settings, identifier):
    with closing(sqlite3.connect(settings.data_dir / "wayproof.sqlite")) as database:
        query = "SELECT client, priority FROM jobs WHERE id = ?"
        return database.execute(query, (identifier,)).fetchone()


@pytest.mark.parametrize(("name", "level"), [("low", -1), ("normal", 0), ("high", 1), (None, 0)])
def test_a_plan_has_the_client_and_the_priority_of_its_request(
    client, settings, scene, name, level
):
    chosen = {} if name is None else {"priority": name}
    plan = client.post("/v1/plans", json={"scene": scene, "group": "arm", "goal": READY, **chosen})
    assert plan.json()["request"]["priority"] == (name or "normal")
    assert row(settings, plan.json()["id"]) == ("address testclient", level)


def test_a_plan_backwards_has_the_priority_of_the_plan(client, settings, scene):
    request = {"scene": scene, "group": "arm", "goal": READY, "priority": "high"}
    plan = client.post("/v1/plans?wait=60", json=request).json()
    assert plan["state"] == "succeeded"
    back = client.post(f"/v1/plans/{plan['id']}/reverse").json()
    assert back["request"]["priority"] == "high"
    assert row(settings, back["id"]) == ("address testclient", 1)


def test_regions_have_a_priority(client, settings, scene):
    request = {"group": "arm", "num_regions": 1, "num_free": 100, "allowed_time": 0.001}
    job = client.post(f"/v1/scenes/{scene}/regions", json={**request, "priority": "low"}).json()
    assert row(settings, job["id"]) == ("address testclient", -1)


def test_there_are_no_other_priorities(client, scene):
    request = {"scene": scene, "group": "arm", "goal": READY, "priority": "urgent"}
    answer = client.post("/v1/plans", json=request)
    assert answer.status_code == 422
    [fault] = answer.json()["errors"]
    assert fault["pointer"] == "/priority"
