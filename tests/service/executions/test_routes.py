"""Executions over HTTP: carried out, refused where the robot is not, steered, stopped."""

import numpy as np
import pytest

from service.client.events import decode_events
from tests.world.meshcat_messages import overlay, tracks

ARM = {"name": "free", "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}]}


@pytest.fixture
def scene(client):
    """A scene of its own for every test: executions leave robots elsewhere."""
    return client.post("/v1/scenes", json=ARM).json()


def planned(client, scene, goal, **fields):
    request = {
        "scene": scene["id"],
        "group": "arm",
        "goal": {"type": "configuration", "name": goal},
    }
    request |= {"search": {"allowed_planning_time": 60.0}, **fields}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    return job


def executed(client, plan, **fields):
    return client.post("/v1/executions?wait=60", json={"plan": plan["id"], "speed": 20, **fields})


def test_a_plan_is_carried_out_to_its_goal(client, scene):
    plan = planned(client, scene, "ready")
    answer = executed(client, plan)
    assert answer.status_code == 200
    execution = answer.json()
    assert answer.headers["location"] == f"/v1/executions/{execution['id']}"
    assert execution["state"] == "succeeded"
    status = execution["status"]
    assert status["progress"] == 1.0
    assert status["contacts"] == []
    assert set(execution["timings"]) == {"load", "execute"}
    assert execution["timings"]["execute"] > 0
    assert 0 < status["max_tracking_error"] < 0.05
    np.testing.assert_allclose(status["positions"], plan["result"]["goal_configuration"], atol=0.01)
    assert client.get(f"/v1/executions/{execution['id']}").json() == execution
    listed = client.get(f"/v1/executions?scene={scene['id']}").json()["items"]
    assert listed == [execution]


def test_statuses_stream_forward_to_the_end(client, scene):
    execution = executed(client, planned(client, scene, "ready"), speed=2).json()
    with client.stream("GET", f"/v1/executions/{execution['id']}/events") as answer:
        events = list(decode_events(answer))
    statuses = [event.data for event in events if event.type == "status"]
    assert events[-1].type == "finished"
    assert statuses[0]["state"] == "executing"
    assert statuses[-1]["state"] == "succeeded"
    times = [status["time"] for status in statuses]
    assert times == sorted(times)
    assert len(times) > 2


def test_a_plan_that_starts_elsewhere_is_refused(client, scene):
    there, elsewhere = planned(client, scene, "ready"), planned(client, scene, "upright")
    assert executed(client, there).json()["state"] == "succeeded"
    for stale in (there, elsewhere):
        answer = executed(client, stale)
        assert answer.status_code == 409
        problem = answer.json()
        assert problem["code"] == "start_mismatch"
        assert problem["evidence"]["distance"] > 0.02
    onward = planned(client, scene, "upright", start=problem["evidence"]["positions"])
    assert executed(client, onward).json()["state"] == "succeeded"


def test_a_robot_does_one_thing_at_a_time_and_can_be_stopped(client, scene):
    plan = planned(client, scene, "ready")
    slow = client.post("/v1/executions", json={"plan": plan["id"], "speed": 0.05})
    assert slow.status_code == 202
    path = slow.headers["location"]
    busy = executed(client, plan)
    assert busy.status_code == 409
    assert busy.json()["code"] == "robot_busy"
    first_status(client, path)
    assert client.post(f"{path}/cancel").json()["state"] in {"canceling", "canceled"}
    ended = finished(client, path)
    assert ended["state"] == "canceled"
    assert ended["failure"]["stage"] == "execute"
    assert set(ended["timings"]) == {"load", "execute", "total"}
    assert ended["timings"] == ended["failure"]["timings"]
    assert 0 <= ended["status"]["progress"] < 1
    assert client.post(f"{path}/cancel").json()["state"] == "canceled"


def test_an_execution_pauses_resumes_and_changes_speed(client, scene):
    plan = planned(client, scene, "ready")
    path = client.post("/v1/executions", json={"plan": plan["id"], "speed": 0.2}).headers[
        "location"
    ]
    assert client.post(f"{path}/pause").status_code == 200
    wait_for(client, path, "paused")
    assert client.post(f"{path}/speed", json={"speed": 20}).status_code == 200
    assert client.post(f"{path}/resume").status_code == 200
    assert finished(client, path)["state"] == "succeeded"
    late = client.post(f"{path}/pause")
    assert late.status_code == 409
    assert late.json()["code"] == "illegal_transition"


def test_what_cannot_be_executed_is_refused(client, scene):
    missing = client.post("/v1/executions", json={"plan": "pln_nothing"})
    assert (missing.status_code, missing.json()["code"]) == (404, "not_found")
    goal = {"type": "pose", "poses": [{"position": [9, 0, 0]}]}
    request = {"scene": scene["id"], "group": "arm", "goal": goal, "ik": {"max_trials": 5}}
    failed = client.post("/v1/plans?wait=60", json=request).json()
    refused = executed(client, failed)
    assert (refused.status_code, refused.json()["code"]) == (409, "no_trajectory")
    for wrong in ({"speed": 0}, {"driver": "real"}, {"speed": "fast"}):
        assert executed(client, failed, **wrong).status_code == 422


def wait_for(client, path, state):
    with client.stream("GET", f"{path}/events") as answer:
        for event in decode_events(answer):
            if event.data.get("state") == state:
                return event.data
    pytest.fail(f"{path} never was {state}")


def first_status(client, path):
    return wait_for(client, path, "executing")


def finished(client, path):
    with client.stream("GET", f"{path}/events") as answer:
        list(decode_events(answer))
    return client.get(path).json()


def test_a_replay_of_a_scene_shows_what_was_executed_in_it(client, scene):
    path = f"/v1/scenes/{scene['id']}/replay.html"
    unmoved = client.get(path)
    assert (unmoved.status_code, unmoved.json()["code"]) == (409, "no_trajectory")
    assert "no execution" in unmoved.json()["detail"]
    there = planned(client, scene, "ready")
    assert executed(client, there, title="lower it").json()["state"] == "succeeded"
    assert executed(client, planned(client, scene, "home")).json()["state"] == "succeeded"
    page = client.get(path)
    assert page.headers["content-type"].startswith("text/html")
    titles = [section["title"] for section in overlay(page.text)["sections"]]
    assert titles == ["lower it", "arm moves"]
    hand = tracks(page.text)["/bodies/arm/hand_base"]
    drop = hand[0, 2, 3] - hand[:, 2, 3]
    assert drop.max() > 0.1
    assert abs(drop[-1]) < 1e-3
    last = client.get(f"{path}?last=1").text
    assert [section["title"] for section in overlay(last)["sections"]] == ["arm moves"]
    assert client.get("/v1/scenes/scn_nothing/replay.html").status_code == 404
    assert client.get(f"{path}?last=0").status_code == 422


def own(client, scene, goal="ready", **fields):
    """Return a motion of one's own: the exact polynomial of a plan."""
    plan = planned(client, scene, goal)
    exact = client.get(f"/v1/plans/{plan['id']}/trajectory?polynomial=true").json()
    return {"scene": scene["id"], "group": "arm", "trajectory": exact, **fields}


def test_a_motion_of_ones_own_is_proven_and_carried_out(client, scene):
    motion = own(client, scene)
    answer = client.post("/v1/executions?wait=60", json={"trajectory": motion, "speed": 20})
    assert answer.status_code == 200, answer.json()
    execution = answer.json()
    assert (execution["state"], execution["group"]) == ("succeeded", "arm")
    assert execution["request"] == {
        "plan": None,
        "plans": None,
        "delays": None,
        "gripper": None,
        "driver": "simulated",
        "speed": 20,
        "on_conflict": "stop",
        "when_busy": "refuse",
        "on_not_certified": "refuse",
        "title": None,
    }
    end = motion["trajectory"]["positions"][-1]
    np.testing.assert_allclose(execution["status"]["positions"], end, atol=0.01)
    again = client.post("/v1/executions", json={"trajectory": motion})
    assert (again.status_code, again.json()["code"]) == (409, "start_mismatch")


def test_a_motion_of_ones_own_that_is_not_proven_is_refused(client, scene):
    motion = own(client, scene)
    hasty = {**motion, "velocity_scale": 0.5}
    refused = client.post("/v1/executions", json={"trajectory": hasty})
    assert (refused.status_code, refused.json()["code"]) == (409, "not_certified")
    assert refused.json()["evidence"]["check"].startswith("velocity")
    samples = motion["trajectory"]
    moving = {
        "times": samples["times"],
        "positions": samples["positions"],
        "velocities": [[0.3] * 6, *samples["velocities"][1:]],
    }
    refused = client.post("/v1/executions", json={"trajectory": {**motion, "trajectory": moving}})
    checks = {check["name"] for check in refused.json()["evidence"]["checks"]}
    assert "rest" in checks  # it begins at rest, or it is none that a robot at rest can begin
    cornered = {"times": [0, 5], "positions": [samples["positions"][0]] * 2}
    cornered["interpolation"] = "linear"
    refused = client.post("/v1/executions", json={"trajectory": {**motion, "trajectory": cornered}})
    assert refused.status_code == 422
    assert refused.json()["evidence"]["field"] == "trajectory.trajectory.interpolation"
    elsewhere = client.post("/v1/executions", json={"trajectory": {**motion, "group": "harm"}})
    assert elsewhere.status_code == 422
    assert elsewhere.json()["errors"][0]["pointer"] == "/trajectory/group"


def test_exactly_one_motion_is_asked_for(client, scene):
    motion = own(client, scene)
    plan = planned(client, scene, "ready")
    for wrong, named in (
        ({}, "exactly one"),
        ({"plan": plan["id"], "trajectory": motion}, "exactly one"),
        ({"trajectory": {**motion, "revision": 1}}, "revision"),
    ):
        refused = client.post("/v1/executions", json=wrong)
        assert (refused.status_code, refused.json()["code"]) == (422, "request_invalid")
        assert named in refused.text


def test_it_goes_back_waits_at_its_beginning_and_goes_on(client, scene):
    plan = planned(client, scene, "ready")
    request = {"plan": plan["id"], "driver": "kinematic", "speed": 0.5}
    path = client.post("/v1/executions", json=request).headers["location"]
    wait_until(client, path, lambda status: status["progress"] > 0.3)
    # Slow enough that a status is told on the way.
    assert client.post(f"{path}/speed", json={"speed": -1}).status_code == 200
    back = wait_until(client, path, lambda status: status["path_velocity"] < -0.5)
    assert back["state"] == "executing"
    assert client.post(f"{path}/speed", json={"speed": -20}).status_code == 200
    waiting = wait_until(client, path, lambda status: status["progress"] == 0)
    assert waiting["state"] == "executing"
    np.testing.assert_allclose(waiting["positions"], plan["result"]["start"], atol=1e-3)
    assert client.post(f"{path}/speed", json={"speed": 0}).status_code == 200
    assert client.get(path).json()["state"] == "executing"
    assert client.post(f"{path}/speed", json={"speed": 20}).status_code == 200
    assert finished(client, path)["state"] == "succeeded"


def test_a_status_says_what_is_measured(client, scene):
    execution = executed(client, planned(client, scene, "ready"), speed=5).json()
    status = execution["status"]
    assert max(map(abs, status["velocities"])) <= 0.01
    assert max(map(abs, status["torques"])) > 1.0  # it is held against gravity
    assert status["path_velocity"] == 0
    jitter = status["jitter"]
    assert jitter["ticks"] > 5
    assert 0 <= jitter["median"] <= jitter["p99"] <= jitter["max"] == status["lateness"]


def test_speeds_beyond_a_hundred_are_refused(client, scene):
    plan = planned(client, scene, "ready")
    path = client.post("/v1/executions", json={"plan": plan["id"]}).headers["location"]
    for speed in (101, -101, "back"):
        assert client.post(f"{path}/speed", json={"speed": speed}).status_code == 422
    client.post(f"{path}/cancel")
    assert finished(client, path)["state"] == "canceled"


def wait_until(client, path, holds):
    with client.stream("GET", f"{path}/events") as answer:
        for event in decode_events(answer):
            if event.type == "status" and holds(event.data):
                return event.data
    pytest.fail(f"{path} ended before")
