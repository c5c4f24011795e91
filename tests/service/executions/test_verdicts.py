"""An edit of the scene while a robot moves: the rest of the motion is proven again, or stops."""

import pytest

from tests.profiles import only_campaign
from tests.service.executions.test_stale_executions import (
    ARM,
    aside,
    edit,
    planned,
    posted,
    tool_pose,
)


@pytest.fixture(scope="module")
def moved(client):
    """A plan from home to ready, and the tool's place at shares of its samples."""
    scene = posted(client, ARM)
    plan = planned(client, scene, "ready")
    rows = plan["result"]["trajectory"]["positions"]

    def place(share):
        q = rows[min(len(rows) - 1, int(share * len(rows)))]
        return tool_pose(client, scene, q)["position"].tolist()

    return plan, place


def begun(client, plan, **fields):
    """The id of an execution that moves."""
    scene = posted(client, ARM)
    again = planned(client, scene, "ready")
    given = {"plan": again["id"], "speed": 0.1, **fields}
    execution = client.post("/v1/executions", json=given).json()["id"]
    while not (status(client, execution) or {}).get("time"):
        pass
    return scene, execution


def status(client, execution):
    return client.get(f"/v1/executions/{execution}").json()["status"]


def ended(client, execution):
    with client.stream("GET", f"/v1/executions/{execution}/events") as stream:
        for _ in stream.iter_lines():
            pass
    return client.get(f"/v1/executions/{execution}").json()


def box(name, position, size=0.1):
    return {
        "op": "add",
        "object": {"name": name, "shape": {"box": [size] * 3}, "pose": {"position": position}},
    }


def test_what_comes_into_the_way_stops_the_robot_on_its_path(client, moved):
    plan, place = moved
    scene, execution = begun(client, plan)
    answer = edit(client, scene, box("late", place(0.7)))
    [verdict] = answer["executions"]
    assert verdict["id"] == execution
    assert (verdict["verdict"], verdict["action"]) == ("conflict", "stop")
    assert verdict["check"] == "clearance"
    assert "late" in verdict["pair"]
    duration = plan["result"]["trajectory"]["duration"]
    assert 0 < verdict["time"] < duration
    assert 0 < verdict["fraction"] < 1
    done = ended(client, execution)
    assert (done["state"], done["failure"]["code"]) == ("aborted", "path_blocked")
    assert done["failure"]["evidence"]["revision"] == answer["revision"]
    # It rests on its path, before the place of the conflict, and touched nothing.
    assert done["status"]["time"] < verdict["time"]
    assert done["status"]["contacts"] == []
    check = {"group": "arm", "configurations": [done["status"]["positions"]]}
    found = client.post(f"/v1/scenes/{scene['id']}/check", json=check).json()["results"]
    assert [each["valid"] for each in found] == [True]


def test_what_is_not_in_the_way_changes_nothing(client, moved):
    plan, _ = moved
    scene, execution = begun(client, plan)
    [verdict] = edit(client, scene, box("far", [3.0, 3.0, 0.5]))["executions"]
    assert (verdict["id"], verdict["verdict"]) == (execution, "unaffected")
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 50})
    assert ended(client, execution)["state"] == "succeeded"


def test_a_conflict_may_be_ignored_on_request(client, moved):
    plan, place = moved
    scene, execution = begun(client, plan, on_conflict="ignore", driver="kinematic")
    [verdict] = edit(client, scene, box("late", place(0.7)))["executions"]
    assert (verdict["verdict"], verdict["action"]) == ("conflict", "ignore")
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 50})
    assert ended(client, execution)["state"] == "succeeded"


@only_campaign("5 s")
def test_what_is_where_the_robot_was_is_behind_it(client):
    scene = posted(client, ARM)
    plan = planned(client, scene, aside(scene, turn=2.0))  # the tool swings far away
    execution = client.post("/v1/executions", json={"plan": plan["id"]}).json()["id"]
    half = plan["result"]["trajectory"]["duration"] / 2
    while ((now := status(client, execution)) or {"time": 0.0})["time"] < half:
        assert now is None or now["state"] in {"accepted", "executing"}
    client.post(f"/v1/executions/{execution}/pause")
    while status(client, execution)["path_velocity"]:
        pass
    first = plan["result"]["trajectory"]["positions"][0]
    behind = tool_pose(client, scene, first)["position"].tolist()
    [verdict] = edit(client, scene, box("behind", behind, 0.02))["executions"]
    assert verdict["verdict"] == "unaffected"
    client.post(f"/v1/executions/{execution}/cancel")
    assert ended(client, execution)["state"] == "canceled"


def test_a_scene_in_which_nothing_moves_has_no_verdicts(client):
    scene = posted(client, ARM)
    assert edit(client, scene, box("far", [3.0, 3.0, 0.5]))["executions"] == []
    goal = planned(client, scene, aside(scene))
    assert goal["state"] == "succeeded"


def test_what_cannot_be_decided_is_blocked(client, moved, monkeypatch):
    plan, _ = moved
    scene, execution = begun(client, plan)
    monkeypatch.setattr("service.executions.proofs.recheck._ALLOWED", 0.0)
    [verdict] = edit(client, scene, box("far", [3.0, 3.0, 0.5]))["executions"]
    assert (verdict["verdict"], verdict["check"]) == ("conflict", "undecided")
    assert ended(client, execution)["failure"]["code"] == "path_blocked"
