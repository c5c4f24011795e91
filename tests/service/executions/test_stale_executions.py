"""Executions hold in the scene as it is now: proven again, from where the robots are."""

import numpy as np
import pytest

from planning.domain.geometry import rotation

ARM = {"name": "free", "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}]}
TWO = {
    "name": "two",
    "robots": [
        {"name": "arm", "model": "ur5e", "positions": "home"},
        {
            "name": "other",
            "model": "ur5e",
            "positions": "home",
            "base": {"position": [0.9, 0, 0]},
        },
    ],
}


def posted(client, document):
    return client.post("/v1/scenes", json=document).json()


def planned(client, scene, goal, group="arm", **fields):
    wanted = {"type": "configuration", "name": goal} if isinstance(goal, str) else goal
    request = {"scene": scene["id"], "group": group, "goal": wanted}
    request |= {"search": {"allowed_planning_time": 20.0}, "refine": {"method": "none"}, **fields}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    return job


def aside(scene, turn=0.3):
    """A goal that the arm reaches soon: its first joint turned from where the scene has it."""
    first, *rest = scene["groups"][0]["positions"]
    return {"type": "joint", "positions": [[first + turn, *rest]]}


def executed(client, plan, **fields):
    return client.post("/v1/executions?wait=60", json={"plan": plan["id"], "speed": 50, **fields})


def edit(client, scene, *operations):
    answer = client.patch(f"/v1/scenes/{scene['id']}", json={"operations": list(operations)})
    assert answer.status_code == 200, answer.text
    return answer.json()


def tool_pose(client, scene, q):
    body = {"group": "arm", "configurations": [q]}
    answer = client.post(f"/v1/scenes/{scene['id']}/fk", json=body).json()
    found = answer["results"][0]["arm::tcp"]
    return {key: np.array(found[key]) for key in ("position", "quaternion")}


def test_an_obstacle_that_came_later_stops_an_execution_before_it_starts(client):
    scene = posted(client, ARM)
    plan = planned(client, scene, "ready")
    rows = plan["result"]["trajectory"]["positions"]
    middle = tool_pose(client, scene, rows[len(rows) // 2])["position"].tolist()
    late = {"name": "late", "shape": {"box": [0.1, 0.1, 0.1]}, "pose": {"position": middle}}
    edit(client, scene, {"op": "add", "object": late})
    answer = executed(client, plan)
    assert answer.status_code == 409, answer.text
    problem = answer.json()
    assert problem["code"] == "not_certified"
    assert problem["evidence"]["check"] == "clearance"
    assert "late" in problem["evidence"]["pair"]
    assert 0 < problem["evidence"]["time"] < plan["result"]["trajectory"]["duration"]
    (failed,) = problem["evidence"]["checks"]
    there = {"group": "arm", "configurations": [failed["positions"]]}
    (verdict,) = client.post(f"/v1/scenes/{scene['id']}/check", json=there).json()["results"]
    assert any("late" in pair["bodies"] for pair in verdict["collisions"])
    edit(client, scene, {"op": "remove", "object": "late"})
    assert executed(client, plan).json()["state"] == "succeeded"


def test_what_is_attached_later_is_part_of_the_motion(client):
    """A stick of 0.6 m across the tool sweeps what the bare tool passes at 0.28 m."""
    stick = {"name": "stick", "shape": {"box": [0.6, 0.02, 0.02]}, "movable": True}
    scene = posted(client, {**ARM, "objects": [{**stick, "pose": {"position": [3, 3, 0.5]}}]})
    first = planned(client, scene, "ready")
    rows = first["result"]["trajectory"]["positions"]
    begin, end = (tool_pose(client, scene, rows[i]) for i in (0, -1))
    p_WC = end["position"] + rotation.matrix(end["quaternion"]) @ np.array([0.28, 0.0, 0.0])
    corner = {"name": "corner", "shape": {"sphere": 0.02}, "pose": {"position": p_WC.tolist()}}
    edit(client, scene, {"op": "add", "object": corner})
    plan = planned(client, scene, "ready")
    pose = {key: value.tolist() for key, value in begin.items()}
    edit(
        client,
        scene,
        {"op": "move", "object": "stick", "pose": pose},
        {"op": "attach", "object": "stick", "frame": "arm::tcp"},
    )
    problem = executed(client, plan).json()
    assert problem["code"] == "not_certified"
    assert set(problem["evidence"]["pair"]) == {"stick", "corner"}


def test_after_an_execution_all_agree_on_where_the_robot_is(client):
    scene = posted(client, ARM)
    goal = planned(client, scene, aside(scene))
    execution = executed(client, goal).json()
    measured = execution["status"]["positions"]
    latest = client.get(f"/v1/scenes/{scene['id']}").json()
    assert latest["revision"] == 1  # the document is what it was
    (group,) = [g for g in latest["groups"] if g["name"] == "arm"]
    assert group["positions"] == measured
    # the plan's start, the guard of the next execution, and a check of it
    onward = planned(client, scene, aside(latest))
    assert onward["result"]["start"] == pytest.approx(measured, abs=1e-6)
    assert executed(client, onward).json()["state"] == "succeeded"
    assert client.get(f"/v1/scenes/{scene['id']}").json()["revision"] == 1


def test_what_is_attached_after_an_execution_is_where_the_robot_is(client):
    block = {"name": "block", "shape": {"box": [0.05] * 3}, "movable": True}
    scene = posted(client, {**ARM, "objects": [{**block, "pose": {"position": [2, 2, 0.5]}}]})
    executed(client, planned(client, scene, aside(scene)))
    measured = client.get(f"/v1/scenes/{scene['id']}").json()["groups"][0]["positions"]
    edit(client, scene, {"op": "attach", "object": "block", "frame": "arm::tcp"})
    body = {"group": "arm", "configurations": [measured], "frames": ["block", "arm::tcp"]}
    found = client.post(f"/v1/scenes/{scene['id']}/fk", json=body).json()["results"][0]
    # It stays where it was in the world, seen from where the arm truly is.
    assert found["block"]["position"] == pytest.approx([2, 2, 0.5], abs=1e-6)


def test_positions_that_are_set_by_hand_are_heeded(client):
    scene = posted(client, ARM)
    plan = planned(client, scene, aside(scene))
    assert executed(client, plan).json()["state"] == "succeeded"
    assert executed(client, plan).json()["code"] == "start_mismatch"
    edit(client, scene, {"op": "set_positions", "robot": "arm", "positions": "home"})
    assert executed(client, plan).json()["state"] == "succeeded"


def test_a_motion_is_held_against_where_other_robots_stand_by_now(client):
    """Both are planned against the other one at home; the second would drive into the first."""
    scene = posted(client, TWO)
    reach = {"type": "pose", "poses": [{"position": [0.45, 0.0, 0.5]}], "frame": "arm::tcp"}
    reach["tolerance"] = {"rotation": [3.2, 3.2, 3.2]}
    over = {**reach, "frame": "other::tcp"}
    mine, other = planned(client, scene, reach), planned(client, scene, over, "other")
    assert executed(client, mine).json()["state"] == "succeeded"
    problem = executed(client, other).json()
    assert problem["code"] == "not_certified"
    assert problem["evidence"]["check"] == "clearance"
