"""The HTTP examples of the guide to goals are what the service takes, and they have solutions."""

import json
import re
from pathlib import Path

import pytest

import planning

PAGE = Path(__file__).parents[2] / "docs" / "goals.md"
BLOCKS = re.findall(r"```json\n(.*?)```", PAGE.read_text(), re.DOTALL)
BODIES = [json.loads(block) for block in BLOCKS]


@pytest.fixture(scope="module")
def pickup_id(client):
    path = planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml"
    headers = {"content-type": "application/yaml"}
    return client.post("/v1/scenes", content=path.read_text(), headers=headers).json()["id"]


@pytest.mark.parametrize("body", [body for body in BODIES if "type" in body], ids=json.dumps)
def test_every_goal_of_the_guide_is_planned_to(client, pickup_id, body):
    request = {"scene": pickup_id, "group": "arm", "goal": body, "refine": {"method": "none"}}
    request["search"] = {"allowed_planning_time": 20.0}
    job = client.post("/v1/plans?wait=30", json=request).json()
    assert job["state"] == "succeeded", job["failure"]


@pytest.mark.parametrize("body", [body for body in BODIES if "group" in body], ids=json.dumps)
def test_every_question_of_the_guide_is_answered(client, pickup_id, body):
    answer = client.post(f"/v1/scenes/{pickup_id}/ik", json=body).json()
    assert answer["configurations"], answer
