"""Objects that are held by contact, over HTTP: carried, lost, and measured where they are."""

import json

import numpy as np
import pytest
import yaml

from tests.profiles import only_campaign
from tests.service.executions.can_in_gripper import GRIPPER, TEXT, positions_at_can, posted

FIRM = {"by": "contact", "friction": 0.8}


@pytest.fixture(scope="module")
def grasping(client):
    return positions_at_can(client)


@pytest.fixture
def scene(client, grasping):
    """A scene of its own, in which the open gripper is around a can of 300 g."""
    return posted(client, document(grasping))


def document(positions, mass=0.3):
    found = yaml.safe_load(TEXT)
    found["robots"][0]["positions"] = positions
    can = next(thing for thing in found["objects"] if thing["name"] == "can")
    if mass is not None:
        can["mass"] = mass
    return found


def gripped(client, scene, force=60.0, speed=5, driver="simulated", **grasp):
    gripper = {"scene": scene, "group": GRIPPER, "grasp": {"object": "can", **FIRM, **grasp}}
    gripper |= {} if force is None else {"force": force}
    body = {"gripper": gripper, "driver": driver, "speed": speed}
    return client.post("/v1/executions?wait=60", json=body)


def lifted(client, scene, speed=2.0, height=0.1):
    """The execution of a lift, at its end."""
    line = {"type": "line", "displacement": {"vector": [0, 0, height]}}
    lift = {"scene": scene, "group": "arm", "goal": line}
    plan = client.post("/v1/plans?wait=60", json=lift).json()
    assert plan["state"] == "succeeded", plan["failure"]
    answer = client.post("/v1/executions?wait=120", json={"plan": plan["id"], "speed": speed})
    assert answer.status_code == 200, answer.text
    return answer.json()


def state_of(client, scene):
    return client.get(f"/v1/scenes/{scene}/state").json()


def can_in_world(client, scene):
    """Where the scene has the can [m], by forward kinematics of its live state."""
    live = client.get(f"/v1/scenes/{scene}").json()
    arm = next(group for group in live["groups"] if group["name"] == "arm")
    body = {"group": "arm", "configurations": [arm["positions"]], "frames": ["can"]}
    (found,) = client.post(f"/v1/scenes/{scene}/fk", json=body).json()["results"]
    return np.array(found["can"]["position"])


def statuses(client, execution):
    text = client.get(f"/v1/executions/{execution['id']}/events").text.replace("\r\n", "\n")
    blocks = [block.splitlines() for block in text.split("\n\n") if "event: status" in block]
    return [
        json.loads(next(line for line in block if line.startswith("data: "))[6:])
        for block in blocks
    ]


def test_a_can_is_carried_by_friction_and_the_scene_has_it_where_it_was_measured(client, scene):
    before = can_in_world(client, scene)
    closed = gripped(client, scene).json()
    assert closed["state"] == "succeeded", closed["failure"]
    (pressed,) = closed["status"]["held"]
    assert (pressed["object"], pressed["is_lost"]) == ("can", False)
    (held,) = state_of(client, scene)["attached"]
    assert (held["object"], held["by"]) == ("can", "contact")
    np.testing.assert_allclose(held["pose"]["position"], pressed["pose"]["position"], atol=1e-9)
    # The fingers touch it now: it is 40 mm wide.
    (gripper,) = state_of(client, scene)["grippers"]
    assert gripper["width"] < 0.0401
    assert gripper["holds"] == ["can"]
    np.testing.assert_allclose(can_in_world(client, scene), before, atol=1e-3)
    done = lifted(client, scene)
    assert done["state"] == "succeeded", done["failure"]
    told = [each["held"][0] for each in statuses(client, done) if each["held"]]
    slips = [each["slip"] for each in told]
    assert 0.0 < max(slips) < 0.005
    rise = told[-1]["world_pose"]["position"][2] - before[2]
    assert rise == pytest.approx(0.1, abs=5e-3)
    np.testing.assert_allclose(
        can_in_world(client, scene), told[-1]["world_pose"]["position"], atol=2e-4
    )
    opened = {"scene": scene, "group": GRIPPER, "width": 0.05, "release": "can"}
    let_go = client.post("/v1/executions?wait=60", json={"gripper": opened, "speed": 5}).json()
    assert let_go["state"] == "succeeded", let_go["failure"]
    assert state_of(client, scene)["attached"] == []


def test_a_can_that_slips_out_is_lost_and_lies_where_it_was_measured(client, scene):
    closed = gripped(client, scene, force=9.0, friction=0.092, slip=0.002).json()
    assert closed["state"] == "succeeded", closed["failure"]
    held_at = can_in_world(client, scene)
    done = lifted(client, scene, speed=2.0)
    assert (done["state"], done["failure"]["code"]) == ("aborted", "grasp_lost"), done["failure"]
    evidence = done["failure"]["evidence"]
    assert evidence["object"] == "can"
    assert evidence["slip"] > evidence["bound"] == 0.002
    assert state_of(client, scene)["attached"] == []
    (last,) = done["status"]["held"]
    assert last["is_lost"]
    lies = can_in_world(client, scene)
    np.testing.assert_allclose(lies, last["world_pose"]["position"], atol=1e-9)
    # The gripper has gone on without it, and the table is below it.
    was_held = closed["status"]["held"][0]["pose"]["position"]
    assert np.linalg.norm(np.subtract(last["pose"]["position"], was_held)) > 1e-3
    assert 0.015 < lies[2] < held_at[2] + 0.1


def test_a_grip_that_is_too_weak_from_the_start_holds_nothing(client, grasping):
    content = document(grasping)
    content["objects"] = [thing for thing in content["objects"] if thing["name"] != "table"]
    content["allowed_collisions"] = []
    scene = posted(client, content)
    before = can_in_world(client, scene)
    closed = gripped(client, scene, force=2.0, friction=0.1).json()
    assert (closed["state"], closed["failure"]["code"]) == ("aborted", "grasp_lost")
    assert state_of(client, scene)["attached"] == []
    assert statuses(client, closed)[-1]["state"] == "aborted"
    # Nothing is below it.
    assert can_in_world(client, scene)[2] < before[2] - 0.01


def test_what_is_held_is_told_while_the_robot_moves(client, scene):
    assert gripped(client, scene).json()["state"] == "succeeded"
    line = {"type": "line", "displacement": {"vector": [0, 0, 0.1]}}
    lift = {"scene": scene, "group": "arm", "goal": line}
    plan = client.post("/v1/plans?wait=60", json=lift).json()
    path = client.post("/v1/executions", json={"plan": plan["id"], "speed": 0.3}).headers[
        "location"
    ]
    told = []
    while client.get(path).json()["state"] not in {"succeeded", "aborted"}:
        told += state_of(client, scene)["attached"]
    measured = [each["slip"] for each in told if each["slip"] is not None]
    assert measured
    assert 0 < max(measured) < 0.005
    assert client.get(path).json()["state"] == "succeeded"


@pytest.mark.parametrize("driver", ["kinematic", "simulated"])
def test_what_cannot_be_held_by_contact_is_refused(client, grasping, driver):
    scene = posted(client, document(grasping, mass=None))
    if driver == "kinematic":
        answer = gripped(client, scene, driver=driver)
        assert (answer.status_code, answer.json()["code"]) == (422, "request_invalid")
        assert gripped(client, scene, force=None).status_code == 422
    else:
        answer = gripped(client, scene)
        assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
        assert "mass" in answer.json()["detail"]
    assert state_of(client, scene)["attached"] == []


@only_campaign("a lift for each of four forces: 20 s")
@pytest.mark.parametrize("share", [0.7, 1.5])
def test_coulombs_friction_decides_what_is_held(client, grasping, share):
    mass, force = 0.4, 30.0
    mu = share * mass * 9.81 / (2 * force)
    scene = posted(client, document(grasping, mass))
    closed = gripped(client, scene, force=force, friction=mu / (2 - mu)).json()
    assert (closed["state"] == "succeeded") == (share > 1), closed["failure"]
