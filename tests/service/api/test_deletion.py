"""Jobs that have ended can be deleted; what goes on cannot, nor what that was asked to use."""

import pytest

from tests.service.conftest import BLOCK_SCENE
from tests.service.servers import until

READY = {"type": "configuration", "name": "ready"}


@pytest.fixture
def own_scene(client):
    return client.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]


@pytest.fixture
def plan(client, own_scene):
    request = {"scene": own_scene, "group": "arm", "goal": READY}
    request["search"] = {"allowed_planning_time": 60.0}
    made = client.post("/v1/plans?wait=60", json=request).json()
    assert made["state"] == "succeeded"
    return made


@pytest.fixture
def slow(client, plan):
    """An execution that goes on for minutes."""
    body = {"plan": plan["id"], "driver": "simulated", "speed": 0.01}
    made = client.post("/v1/executions", json=body).json()
    path = f"/v1/executions/{made['id']}"
    until(lambda: client.get(path).json()["state"] == "executing")
    yield path
    client.post(f"{path}/cancel")


def refused(answer, code):
    return (answer.status_code, answer.json()["code"]) == (409, code)


def test_a_deleted_plan_is_unknown_in_every_way(client, plan):
    path = f"/v1/plans/{plan['id']}"
    ways = ("", "/events", "/trajectory", "/series", "/replay.html", "/graph", "/report.html")
    ways += ("/bundle.zip", "/plots/position.svg")
    for further in ways:
        assert client.get(f"{path}{further}").status_code in {200, 409}, further
    answer = client.delete(path)
    assert (answer.status_code, answer.content) == (204, b"")
    for further in ways:
        assert client.get(f"{path}{further}").status_code == 404, further
    for further in ("/cancel", "/reverse"):
        assert client.post(f"{path}{further}").status_code == 404, further
    assert client.post("/v1/executions", json={"plan": plan["id"]}).status_code == 404
    again = client.delete(path)
    assert (again.status_code, again.json()["code"]) == (404, "not_found")
    listed = client.get("/v1/plans?limit=200").json()["items"]
    assert plan["id"] not in {item["id"] for item in listed}


def test_a_deleted_plan_gives_its_key_free(client, plan):
    headers = {"Idempotency-Key": plan["id"]}
    first = client.post("/v1/plans?wait=60", json=plan["request"], headers=headers).json()
    assert client.delete(f"/v1/plans/{first['id']}").status_code == 204
    again = client.post("/v1/plans?wait=60", json=plan["request"], headers=headers).json()
    assert again["id"] != first["id"]
    assert again["digest"] == first["digest"]


def test_what_goes_on_is_not_deleted_and_nor_is_what_it_uses(client, plan, slow):
    told = client.delete(slow)
    assert refused(told, "illegal_transition")
    assert told.json()["evidence"] == {"state": "running", "event": "delete", "legal": ["cancel"]}
    told = client.delete(f"/v1/plans/{plan['id']}")
    assert refused(told, "resource_in_use")
    assert told.json()["evidence"]["used_by"] in slow
    client.post(f"{slow}/cancel")
    until(lambda: client.get(slow).json()["state"] == "canceled")
    assert client.delete(f"/v1/plans/{plan['id']}").status_code == 204
    left = client.get(slow).json()
    assert left["request"]["plan"] == plan["id"]
    assert client.delete(slow).status_code == 204
    assert client.get(slow).status_code == 404


def test_a_robot_stays_where_a_deleted_execution_left_it(client, own_scene, plan):
    body = {"plan": plan["id"], "driver": "simulated", "speed": 100.0}
    made = client.post("/v1/executions?wait=60", json=body).json()
    assert made["state"] == "succeeded"
    assert client.delete(f"/v1/executions/{made['id']}").status_code == 204
    positions = client.get(f"/v1/scenes/{own_scene}").json()["groups"][0]["positions"]
    assert positions == pytest.approx(made["status"]["positions"])
    again = client.post("/v1/executions", json=body)
    assert refused(again, "start_mismatch")
    assert client.get(f"/v1/scenes/{own_scene}/replay.html").status_code in {200, 409}


def test_regions_go_and_plans_that_were_made_in_them_stay(client):
    # Regions fit whatever scene has the content that they were grown in: this one has its own.
    cell = {**BLOCK_SCENE, "margin": 0.000123}
    own_scene = client.post("/v1/scenes", json=cell).json()["id"]
    grow = {"group": "arm", "num_regions": 1, "num_free": 100, "iterations": 1, "along": "nothing"}
    grow["allowed_time"] = 60.0
    made = client.post(f"/v1/scenes/{own_scene}/regions?wait=60", json=grow).json()
    request = {"scene": own_scene, "group": "arm", "goal": READY, "search": {"planner": "GCS"}}
    plan = client.post("/v1/plans?wait=60", json=request).json()
    assert plan["request"]["search"]["regions"] == made["id"]
    assert client.delete(f"/v1/regions/{made['id']}").status_code == 204
    assert client.get(f"/v1/regions/{made['id']}").status_code == 404
    assert client.get(f"/v1/plans/{plan['id']}").json() == plan
    assert refused(client.post("/v1/plans", json=request), "no_regions")


@pytest.mark.parametrize("path", ["plans/pln_0", "regions/reg_0", "executions/exe_0", "plans/x"])
def test_what_there_is_not_is_not_found(client, path):
    answer = client.delete(f"/v1/{path}")
    assert (answer.status_code, answer.json()["code"]) == (404, "not_found")
