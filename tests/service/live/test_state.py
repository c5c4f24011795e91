"""The live state over HTTP: executions leave it, edits by hand replace it, all begins there."""

import numpy as np
import pytest
import yaml

import planning
from service.client.events import decode_events
from service.scenes.live import RobotStatus
from service.scenes.store.live_rows import write_measured

CELL = {
    "name": "cell",
    "robots": [
        {"name": "body", "model": "planar_l", "positions": [-0.35, -0.3, 0.0]},
        {
            "name": "other",
            "model": "planar_l",
            "positions": [0.0, 0.0, 0.0],
            "base": {"position": [0, 0.9, 0]},
        },
    ],
    "objects": [
        {
            "name": "post",
            "shape": {"box": [0.05, 0.05, 0.2]},
            "pose": {"position": [2, 2, 0]},
            "movable": True,
        }
    ],
}
NEAR = [-0.2, -0.3, 0.2]


@pytest.fixture
def scene(client):
    return posted(client, CELL)


def posted(client, document):
    answer = client.post("/v1/scenes", json=document)
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


def planned(client, scene, goal, group="body", **fields):
    wanted = {"type": "joint", "positions": goal} if isinstance(goal, list) else goal
    request = {"scene": scene, "group": group, "goal": wanted, "refine": {"method": "none"}}
    request |= {"search": {"allowed_planning_time": 60.0}, **fields}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    return job


def executed(client, plan, **fields):
    return client.post("/v1/executions?wait=60", json={"plan": plan["id"], "speed": 50, **fields})


def moved(client, scene, goal, group="body", **fields):
    """The id of an execution that has succeeded, and what it measured last."""
    answer = executed(client, planned(client, scene, goal, group, **fields))
    assert answer.status_code == 200, answer.text
    assert answer.json()["state"] == "succeeded"
    return answer.json()["id"], answer.json()["status"]["positions"]


def edited(client, scene, *operations):
    answer = client.patch(f"/v1/scenes/{scene}", json={"operations": list(operations)})
    assert answer.status_code == 200, answer.text
    return answer.json()


def state_of(client, scene, robot="body"):
    (found,) = [each for each in whole(client, scene)["robots"] if each["robot"] == robot]
    return found


def whole(client, scene):
    answer = client.get(f"/v1/scenes/{scene}/state")
    assert answer.status_code == 200, answer.text
    return answer.json()


def positions(state):
    """Of the one joint of a robot in the plane."""
    (found,) = state["positions"].values()
    return found


def test_at_first_the_document_says_it(client, scene):
    told = whole(client, scene)
    assert (told["scene"], told["revision"], told["attached"]) == (scene, 1, [])
    assert [each["robot"] for each in told["robots"]] == ["body", "other"]
    body = told["robots"][0]
    assert body["source"] == {"type": "document", "revision": 1}
    assert (body["status"], body["execution"]) == ("at_rest", None)
    assert positions(body) == [-0.35, -0.3, 0.0]


def test_an_execution_leaves_what_it_measured_and_changes_no_revision(client, scene):
    before = client.get(f"/v1/scenes/{scene}")
    execution, measured = moved(client, scene, NEAR)
    after = client.get(f"/v1/scenes/{scene}")
    assert after.headers["etag"] == before.headers["etag"]
    for part in ("revision", "digest", "document", "created_at"):
        assert after.json()[part] == before.json()[part]
    assert after.json()["groups"][0]["positions"] == measured
    body = state_of(client, scene)
    assert positions(body) == measured
    assert (body["status"], body["source"]) == ("at_rest", {"type": "execution", "id": execution})
    with client.stream("GET", f"/v1/executions/{execution}/events") as events:
        *_, last = decode_events(events)
    assert (last.type, last.data["at"]) == ("finished", body["updated_at"])
    assert state_of(client, scene, "other")["source"]["type"] == "document"


def test_plans_and_questions_begin_where_the_robot_was_left(client, scene):
    _, measured = moved(client, scene, NEAR)
    assert planned(client, scene, [0.0, -0.3, 0.0])["result"]["start"] == measured
    described = planned(client, scene, [0.0, -0.3, 0.0], revision=1)
    assert described["result"]["start"] == [-0.35, -0.3, 0.0]
    assert executed(client, described).json()["code"] == "start_mismatch"
    moved(client, scene, [0.0, -0.3, 0.0])
    group = client.get(f"/v1/scenes/{scene}?revision=1").json()["groups"][0]
    assert group["positions"] == [-0.35, -0.3, 0.0]


def test_other_robots_are_checked_against_where_it_was_left(client, scene):
    where = {"group": "other", "configurations": [[0.0, -0.5, 0.0]]}
    check = f"/v1/scenes/{scene}/check"
    assert client.post(check, json=where).json()["results"][0]["valid"]
    moved(client, scene, [0.0, 0.3, 0.0])
    found = client.post(check, json=where).json()["results"][0]
    assert not found["valid"]
    assert client.post(f"{check}?revision=1", json=where).json()["results"][0]["valid"]


def test_a_plan_says_where_it_began_and_gives_the_same_again(client, scene):
    moved(client, scene, NEAR)
    plan = planned(client, scene, [0.0, -0.3, 0.0], seed=5)
    moved(client, scene, [-0.1, -0.3, 0.0])
    again = client.post("/v1/plans?wait=60", json=plan["request"]).json()
    assert again["result"]["digest"] == plan["result"]["digest"]


def test_positions_set_by_hand_replace_what_was_measured(client, scene):
    moved(client, scene, NEAR)
    placed = edited(
        client, scene, {"op": "set_positions", "robot": "body", "positions": [-0.3, -0.3, 0.1]}
    )
    body = state_of(client, scene)
    assert positions(body) == [-0.3, -0.3, 0.1]
    assert body["source"] == {"type": "edit", "revision": 2}
    assert body["updated_at"] == placed["created_at"]
    assert planned(client, scene, NEAR)["result"]["start"] == [-0.3, -0.3, 0.1]


def test_an_obstacle_keeps_robots_where_they_are_and_enters_no_measurement_into_the_document(
    client, scene
):
    execution, measured = moved(client, scene, NEAR)
    new = {"name": "new", "shape": {"sphere": 0.1}, "pose": {"position": [9, 9, 0]}}
    after = edited(client, scene, {"op": "add", "object": new})
    assert after["revision"] == 2
    assert after["groups"][0]["positions"] == measured
    assert (
        after["document"]["robots"]
        == client.get(f"/v1/scenes/{scene}?revision=1").json()["document"]["robots"]
    )
    body = state_of(client, scene)
    assert (positions(body), body["source"]["id"]) == (measured, execution)
    assert planned(client, scene, [0.0, -0.3, 0.0])["result"]["start"] == measured


def test_joints_that_are_not_set_stay_where_they_were_left(client):
    arm = {"name": "arm", "model": "ur5e", "positions": "home"}
    scene = posted(client, {"name": "free", "robots": [arm]})
    home = client.get(f"/v1/scenes/{scene}").json()["groups"][0]["positions"]
    _, measured = moved(client, scene, [[home[0] + 0.3, *home[1:]]], "arm")
    wrist = {"wrist_3_joint": 0.5}
    edited(client, scene, {"op": "set_positions", "robot": "arm", "positions": wrist})
    group = client.get(f"/v1/scenes/{scene}").json()["groups"][0]
    assert group["positions"] == [*measured[:5], 0.5]
    again = client.get(f"/v1/scenes/{scene}?revision=2").json()["groups"][0]
    assert again["positions"] == group["positions"]


def test_what_is_picked_is_attached_where_the_gripper_is(client):
    """It was 0.33 m beside the gripper when an edit did not know what had been executed."""
    path = planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml"
    scene = posted(client, yaml.safe_load(path.read_text()))
    pick = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
    pick["approach"] = [0, 0, -0.1]
    moved(client, scene, pick, "arm")
    reached = state_of(client, scene, "arm")["positions"]
    close = {"type": "joint", "positions": [[0.0202]]}
    _, (finger,) = moved(client, scene, close, "arm::gripper")
    left = state_of(client, scene, "arm")["positions"]
    assert left == reached | {"left_finger_joint": finger}  # one group does not undo another
    home = client.get(f"/v1/scenes/{scene}?revision=1").json()["document"]["robots"]
    after = edited(client, scene, {"op": "attach", "object": "can", "frame": "arm::tcp"})
    assert after["document"]["robots"] == home  # the state is not the description
    (held,) = whole(client, scene)["attached"]
    assert (held["object"], held["frame"], held["by"]) == ("can", "arm::tcp", "weld")
    (can,) = [each for each in after["document"]["objects"] if each["name"] == "can"]
    assert np.linalg.norm(can["pose"]["position"]) < 0.1
    lift = {"type": "line", "displacement": {"vector": [0, 0, 0.1]}}
    before = frames_of(client, scene)
    moved(client, scene, lift, "arm")
    now = frames_of(client, scene)
    assert now["can"][2] - before["can"][2] == pytest.approx(0.1, abs=0.01)
    edited(client, scene, {"op": "detach", "object": "can"})
    assert whole(client, scene)["attached"] == []
    assert frames_of(client, scene)["can"] == pytest.approx(now["can"], abs=1e-9)


def frames_of(client, scene):
    q = client.get(f"/v1/scenes/{scene}").json()["groups"][0]["positions"]
    body = {"group": "arm", "configurations": [q], "frames": ["can", "arm::tcp"]}
    found = client.post(f"/v1/scenes/{scene}/fk", json=body).json()["results"][0]
    return {name: np.array(each["position"]) for name, each in found.items()}


def test_a_deleted_execution_leaves_the_state_and_the_next_one_is_heeded(client, scene):
    """Its place in the order of jobs is another one's then."""
    execution, measured = moved(client, scene, NEAR)
    assert client.delete(f"/v1/executions/{execution}").status_code == 204
    body = state_of(client, scene)
    assert (positions(body), body["source"]["id"]) == (measured, execution)
    onward, measured = moved(client, scene, [0.0, -0.3, 0.0])
    body = state_of(client, scene)
    assert (positions(body), body["source"]["id"]) == (measured, onward)


def test_a_canceled_execution_leaves_the_robot_where_it_came_to_rest(client, scene):
    plan = planned(client, scene, NEAR)
    path = begun(client, plan)
    client.post(f"{path}/cancel")
    ended = finished(client, path)
    assert ended["state"] == "canceled"
    body = state_of(client, scene)
    assert positions(body) == ended["status"]["positions"]
    assert positions(body) != [-0.35, -0.3, 0.0]
    moved(client, scene, NEAR)


def begun(client, plan, speed=0.2):
    """The path of an execution that moves."""
    answer = client.post("/v1/executions", json={"plan": plan["id"], "speed": speed})
    path = answer.headers["location"]
    with client.stream("GET", f"{path}/events") as events:
        for event in decode_events(events):
            if event.data.get("state") == "executing" and event.data["progress"] > 0.05:
                return path
    pytest.fail("it never moved")


def finished(client, path):
    with client.stream("GET", f"{path}/events") as answer:
        list(decode_events(answer))
    return client.get(path).json()


def test_what_moves_is_not_placed_by_hand_and_the_scene_can_be_edited_beside_it(client):
    scene = posted(client, CELL)
    path = begun(client, planned(client, scene, NEAR), speed=0.02)
    place = {"op": "set_positions", "robot": "body", "positions": [0.0, 0.0, 0.0]}
    attach = {"op": "attach", "object": "post", "frame": "body::body"}
    for operation in (place, attach):
        refused = client.patch(f"/v1/scenes/{scene}", json={"operations": [operation]})
        assert (refused.status_code, refused.json()["code"]) == (409, "robot_busy")
        assert refused.json()["evidence"] == {"execution": path.rsplit("/", 1)[1], "group": "body"}
    edited(client, scene, place | {"robot": "other", "positions": [0.1, 0.0, 0.0]})
    body = state_of(client, scene)
    assert (body["status"], body["execution"]) == ("moving", path.rsplit("/", 1)[1])
    assert body["source"] == {"type": "execution", "id": body["execution"]}
    client.post(f"{path}/cancel")
    finished(client, path)
    assert state_of(client, scene)["status"] == "at_rest"
    assert state_of(client, scene, "other")["source"] == {"type": "edit", "revision": 2}
    edited(client, scene, place)


def test_what_a_client_knows_is_sent_again_once_the_robot_has_moved(client, scene):
    etag = client.get(f"/v1/scenes/{scene}").headers["etag"]
    known = {"If-None-Match": etag}
    assert client.get(f"/v1/scenes/{scene}", headers=known).status_code == 304
    _, measured = moved(client, scene, NEAR)
    again = client.get(f"/v1/scenes/{scene}", headers=known)
    assert (again.status_code, again.headers["etag"]) == (200, etag)
    assert again.json()["groups"][0]["positions"] == measured


def test_beside_a_robot_that_is_lost_nothing_moves_until_it_is_placed(client, app, scene):
    plan = planned(client, scene, NEAR, "other")
    lost(app, scene)
    assert state_of(client, scene)["status"] == "unknown"
    refused = executed(client, plan)
    assert (refused.status_code, refused.json()["code"]) == (409, "robot_state_unknown")
    assert refused.json()["evidence"] == {"robots": ["body"]}
    there = state_of(client, scene)["positions"]
    edited(client, scene, {"op": "set_positions", "robot": "body", "positions": there})
    assert state_of(client, scene)["status"] == "at_rest"
    assert executed(client, planned(client, scene, NEAR, "other")).status_code == 200


def lost(app, scene):
    """What is written when the driver of a real robot dies."""
    scenes = app.state.scenes
    at = scenes.latest.of(scene).created_at
    where = {"body": {"base_joint": [-0.3, -0.3, 0.0]}}
    with scenes.latest.changing(scene), scenes._durable() as connection:
        write_measured(connection, scene, where, RobotStatus.UNKNOWN, "exe_lost", at)


def test_there_is_no_state_of_what_is_not_there(client, scene):
    client.delete(f"/v1/scenes/{scene}")
    for path in (scene, "scn_nothing"):
        answer = client.get(f"/v1/scenes/{path}/state")
        assert (answer.status_code, answer.json()["code"]) == (404, "not_found")
