"""Grippers over HTTP: they open and close, take hold of objects and let them go."""

import itertools

import numpy as np
import pytest
import yaml

from tests.service.executions.can_in_gripper import GRIPPER, TEXT, positions_at_can, posted


@pytest.fixture(scope="module")
def grasping(client):
    return positions_at_can(client)


@pytest.fixture
def scene(client, grasping):
    """A scene of its own, in which the open gripper is around the can."""
    document = yaml.safe_load(TEXT)
    document["robots"][0]["positions"] = grasping
    return posted(client, document)


def moved(client, scene, driver="simulated", group=GRIPPER, **gripper):
    body = {"gripper": {"scene": scene, "group": group, **gripper}, "driver": driver, "speed": 5}
    return client.post("/v1/executions?wait=60", json=body)


def succeeded(client, scene, driver="simulated", **gripper):
    answer = moved(client, scene, driver, **gripper)
    assert answer.status_code == 200, answer.text
    assert answer.json()["state"] == "succeeded", answer.json()["failure"]
    return answer.json()


def state_of(client, scene):
    return client.get(f"/v1/scenes/{scene}/state").json()


def gripper_of(client, scene):
    (found,) = state_of(client, scene)["grippers"]
    return found


def can_in_world(client, scene):
    """Where the can is, by forward kinematics of the live state."""
    live = client.get(f"/v1/scenes/{scene}").json()
    arm = next(group for group in live["groups"] if group["name"] == "arm")
    body = {"group": "arm", "configurations": [arm["positions"]], "frames": ["can"]}
    (found,) = client.post(f"/v1/scenes/{scene}/fk", json=body).json()["results"]
    return np.array(found["can"]["position"] + found["can"]["quaternion"])


@pytest.mark.parametrize("driver", ["simulated", "kinematic"])
def test_a_can_is_held_once_the_fingers_have_closed_on_it_and_let_go_of_after(
    client, scene, driver
):
    before = can_in_world(client, scene)
    assert gripper_of(client, scene)["width"] == pytest.approx(0.05)
    closed = succeeded(client, scene, driver, grasp={"object": "can"})
    assert closed["status"]["contacts"] == []
    held = gripper_of(client, scene)
    # The can is 40 mm wide, and neither finger touches it.
    assert 0.040 < held["width"] < 0.0408
    assert held["width"] == pytest.approx(2 * closed["status"]["positions"][0])
    assert held["holds"] == ["can"]
    (attached,) = state_of(client, scene)["attached"]
    assert (attached["object"], attached["frame"]) == ("can", "arm::tcp")
    assert (attached["by"], attached["slip"]) == ("weld", None)
    np.testing.assert_allclose(can_in_world(client, scene), before, atol=1e-9)
    assert state_of(client, scene)["revision"] == 2
    succeeded(client, scene, driver, width=0.05, release="can")
    opened = gripper_of(client, scene)
    assert opened["width"] == pytest.approx(0.05, abs=2e-4)
    assert opened["holds"] == []
    assert state_of(client, scene)["revision"] == 3
    np.testing.assert_allclose(can_in_world(client, scene), before, atol=1e-9)


def test_the_object_is_held_before_the_end_is_told(client, scene):
    succeeded(client, scene, "kinematic", grasp={"object": "can"})
    line = {"type": "line", "displacement": {"vector": [0, 0, 0.1]}}
    lift = {"scene": scene, "group": "arm", "goal": line}
    plan = client.post("/v1/plans?wait=60", json=lift).json()
    assert plan["state"] == "succeeded", plan["failure"]
    assert plan["request"]["revision"] in {2, None}
    before = can_in_world(client, scene)
    body = {"plan": plan["id"], "driver": "kinematic", "speed": 20}
    done = client.post("/v1/executions?wait=60", json=body).json()
    assert done["state"] == "succeeded", done["failure"]
    lifted = can_in_world(client, scene)
    np.testing.assert_allclose(lifted[:3] - before[:3], [0, 0, 0.1], atol=2e-3)


def test_widths_are_reached_and_no_object_is_taken(client, scene):
    for width in (0.045, 0.042, 0.05):
        succeeded(client, scene, "kinematic", width=width)
        found = gripper_of(client, scene)
        assert found["width"] == pytest.approx(width, abs=1e-5)
        assert (found["max_width"], found["holds"]) == (pytest.approx(0.05), [])
    assert state_of(client, scene)["revision"] == 1


def test_fingers_that_would_go_into_an_object_are_not_moved(client, scene):
    answer = moved(client, scene, width=0.03)
    assert (answer.status_code, answer.json()["code"]) == (409, "not_certified")
    assert gripper_of(client, scene)["width"] == pytest.approx(0.05)


def test_an_object_that_is_not_between_the_fingers_is_not_held(client, scene):
    answer = moved(client, scene, grasp={"object": "box"})
    assert (answer.status_code, answer.json()["code"]) == (409, "grasp_missed")
    assert answer.json()["evidence"]["object"] == "box"
    # Moved by 4 mm, the can is reached by one finger alone.
    document = client.get(f"/v1/scenes/{scene}").json()["document"]
    can = next(thing for thing in document["objects"] if thing["name"] == "can")
    far: list[float] = []
    for i, sign in itertools.product((0, 1), (1, -1)):
        place = list(can["pose"]["position"])
        place[i] += sign * 0.004
        pose = {**can["pose"], "position": place}
        edit = {"operations": [{"op": "move", "object": "can", "pose": pose}]}
        assert client.patch(f"/v1/scenes/{scene}", json=edit).status_code == 200
        answer = moved(client, scene, "kinematic", grasp={"object": "can", "reach": 0.001})
        if answer.status_code == 409:
            assert answer.json()["code"] == "grasp_missed"
            far.append(max(answer.json()["evidence"]["distances"]))
        else:  # along the fingers
            succeeded(client, scene, "kinematic", width=0.05, release="can")
    assert far
    assert all(0.001 < each < 0.009 for each in far)


def test_a_margin_does_not_keep_fingers_from_what_they_shall_hold(client, grasping):
    document = yaml.safe_load(TEXT) | {"margin": 0.003}
    document["robots"][0]["positions"] = grasping
    # Else it is nearer to the table than the margin allows, as the can of the arm.
    document["allowed_collisions"] += [["can", "table"]]
    scene = posted(client, document)
    refused = moved(client, scene, "kinematic", width=0.0404)
    assert (refused.status_code, refused.json()["code"]) == (409, "not_certified")
    succeeded(client, scene, "kinematic", grasp={"object": "can"})
    # Opened by a hair, the can would be nearer to the fingers than the margin.
    body = moved(client, scene, "kinematic", width=0.0406, release="can")
    assert (body.status_code, body.json()["evidence"]["check"]) == (409, "release")
    assert gripper_of(client, scene)["holds"] == ["can"]
    succeeded(client, scene, "kinematic", width=0.05, release="can")


def test_what_was_canceled_holds_nothing(client, scene):
    body = {"gripper": {"scene": scene, "group": GRIPPER, "grasp": {"object": "can"}}}
    begun = client.post("/v1/executions", json={**body, "speed": 0.01})
    path = begun.headers["location"]
    client.post(f"{path}/cancel")
    ended = client.get(path).json()
    while ended["state"] not in {"canceled", "succeeded", "aborted"}:
        ended = client.get(path).json()
    assert ended["state"] == "canceled"
    assert gripper_of(client, scene)["holds"] == []
    assert state_of(client, scene)["revision"] == 1


def test_an_object_that_was_removed_meanwhile_is_not_held_and_the_execution_says_so(client, scene):
    body = {"gripper": {"scene": scene, "group": GRIPPER, "grasp": {"object": "can"}}}
    terms = {**body, "driver": "kinematic", "speed": 0.05, "on_conflict": "ignore"}
    path = client.post("/v1/executions", json=terms).headers["location"]
    removed = {"operations": [{"op": "remove", "object": "can"}]}
    assert client.patch(f"/v1/scenes/{scene}", json=removed).status_code == 200
    client.post(f"{path}/speed", json={"speed": 20})
    ended = client.get(path).json()
    while ended["state"] not in {"canceled", "succeeded", "aborted"}:
        ended = client.get(path).json()
    assert (ended["state"], ended["failure"]["code"]) == ("aborted", "unknown_name")
    assert gripper_of(client, scene)["holds"] == []


def test_an_edit_while_fingers_close_is_judged_as_the_grasp_was_proven(client, grasping):
    document = yaml.safe_load(TEXT) | {"margin": 0.003}
    document["robots"][0]["positions"] = grasping
    document["allowed_collisions"] += [["can", "table"]]
    scene = posted(client, document)
    body = {"gripper": {"scene": scene, "group": GRIPPER, "grasp": {"object": "can"}}}
    begun = client.post("/v1/executions", json={**body, "driver": "kinematic", "speed": 0.01})
    assert begun.status_code == 202, begun.text
    path = begun.headers["location"]
    far = {"name": "late", "shape": {"box": [0.1, 0.1, 0.1]}, "pose": {"position": [-1, 0, 1]}}
    edit = {"operations": [{"op": "add", "object": far}]}
    verdicts = client.patch(f"/v1/scenes/{scene}", json=edit).json()["executions"]
    assert [each["verdict"] for each in verdicts] == ["unaffected"]
    client.post(f"{path}/speed", json={"speed": 20})
    ended = client.get(path).json()
    while ended["state"] not in {"canceled", "succeeded", "aborted"}:
        ended = client.get(path).json()
    assert ended["state"] == "succeeded", ended["failure"]
    assert gripper_of(client, scene)["holds"] == ["can"]


def test_a_gripper_has_no_more_force_than_was_asked_for(client, scene):
    answer = moved(client, scene, grasp={"object": "can"}, force=2e-5)
    assert answer.json()["state"] == "aborted"
    assert answer.json()["failure"]["code"] in {"torque_limit_reached", "tracking_lost"}
    torques = answer.json()["status"]["torques"]
    assert max(map(abs, torques)) <= 2e-5 + 1e-9
    assert gripper_of(client, scene)["holds"] == []
    succeeded(client, scene, grasp={"object": "can"}, force=60.0)


@pytest.mark.parametrize(
    ("gripper", "code", "pointer"),
    [
        ({}, "request_invalid", None),
        ({"width": 0.01, "grasp": {"object": "can"}}, "request_invalid", None),
        ({"grasp": {"object": "can"}, "release": "can"}, "request_invalid", None),
        ({"grasp": {"object": "cann"}}, "unknown_name", "/gripper/grasp/object"),
        ({"grasp": {"object": "can", "frame": "arm::tpc"}}, "unknown_name", "/gripper/grasp/frame"),
        ({"group": "arm::griper", "width": 0.02}, "unknown_name", "/gripper/group"),
        ({"group": "arm", "width": 0.02}, "problem_invalid", None),
        ({"width": 0.08}, "problem_invalid", None),
        ({"width": 0.05}, "problem_invalid", None),
        ({"grasp": {"object": "table"}}, "scene_edit_impossible", None),
        ({"width": 0.04, "release": "can"}, "scene_edit_impossible", None),
    ],
)
def test_what_no_gripper_can_do_is_refused(client, scene, gripper, code, pointer):
    body = {"gripper": {"scene": scene, "group": GRIPPER, **gripper}}
    answer = client.post("/v1/executions", json=body)
    assert (answer.status_code, answer.json()["code"]) in {(422, code), (409, code)}
    if pointer is not None:
        assert [error["pointer"] for error in answer.json()["errors"]] == [pointer]
