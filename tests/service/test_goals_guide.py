"""The HTTP examples of the guide to goals are what the service takes, and they have solutions."""

import json

import pytest

import planning
from tests.conventions.guide import ROOT, calls, values

PAGE = ROOT / "docs" / "how-to" / "plan" / "goals.md"
BODIES = list(values(PAGE))


def posted(client):
    path = planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml"
    headers = {"content-type": "application/yaml"}
    return client.post("/v1/scenes", content=path.read_text(), headers=headers).json()["id"]


@pytest.fixture(scope="module")
def pickup_id(client):
    return posted(client)


@pytest.fixture(scope="module")
def held_id(client):
    """The scene after the page's edit: the robot holds the can."""
    [edit] = calls(PAGE)
    identifier = posted(client)
    path = edit.path.replace("SCENE", identifier)
    assert client.request(edit.method, path, json=edit.body).status_code == 200
    return identifier


@pytest.mark.parametrize("body", [body for body in BODIES if "type" in body], ids=json.dumps)
def test_every_goal_of_the_guide_is_planned_to(client, pickup_id, held_id, body):
    scene = held_id if body.get("frame") == "can" else pickup_id
    request = {"scene": scene, "group": "arm", "goal": body, "refine": {"method": "none"}}
    request["search"] = {"allowed_planning_time": 60.0}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]


@pytest.mark.parametrize("body", [body for body in BODIES if "group" in body], ids=json.dumps)
def test_every_question_of_the_guide_is_answered(client, pickup_id, body):
    answer = client.post(f"/v1/scenes/{pickup_id}/ik", json=body).json()
    assert answer["configurations"], answer
