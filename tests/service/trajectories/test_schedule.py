"""When the motions of several plans begin: over HTTP, with all that can be wrong."""

import numpy as np
import pytest

from service.trajectories.planned_motions import combined_motion, planned_motions

TWO = {
    "name": "two",
    "robots": [
        {"name": "l", "model": "irb120", "base": {"position": [0, 0.35, 0]}},
        {"name": "r", "model": "irb120", "base": {"position": [0, -0.35, 0]}},
    ],
    "groups": {"both": ["l", "r"]},
    "configurations": {
        "low": {"group": "both", "positions": [0, 0.4, 0.3, 0, 0.87, 0, 0, 0.4, 0.3, 0, 0.87, 0]}
    },
}
DOWN = [0, 1, 0, 0]


@pytest.fixture(scope="module")
def two(client):
    answer = client.post("/v1/scenes", json=TWO)
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


def plan(client, scene, group, goal, **more):
    body = {"scene": scene, "group": group, "goal": goal, **more}
    body.setdefault("search", {"allowed_planning_time": 60})
    answer = client.post("/v1/plans?wait=60", json=body)
    assert answer.status_code == 200, answer.text
    assert answer.json()["state"] == "succeeded", answer.text
    return answer.json()


def inwards(side):
    position = [0.38, 0.05 if side == "r" else -0.05, 0.1]
    return {"type": "pose", "poses": [{"position": position, "quaternion": DOWN}]}


@pytest.fixture(scope="module")
def crossing(client, two):
    """A plan of each arm into the other one's half, and one of each back again."""
    slowly = {"l": {"velocity_scale": 0.1}, "r": {}}
    into = [plan(client, two, side, inwards(side), retime=slowly[side]) for side in "lr"]
    back = [client.post(f"/v1/plans/{one['id']}/reverse?wait=60").json() for one in into]
    return [one["id"] for one in into], [one["id"] for one in back]


def post(client, scene, plans, **more):
    body = {"scene": scene, "plans": plans, "allowed_time": 60, **more}
    return client.post("/v1/trajectories/schedule", json=body)


def test_one_goes_in_while_the_other_one_comes_out(client, two, crossing):
    into, back = crossing
    answer = post(client, two, [back[0], into[1]], polynomial=True)
    assert answer.status_code == 200, answer.text
    found = answer.json()["schedule"]
    assert answer.json()["failure"] is None
    assert found["certificate"]["proven"]
    assert found["group"] == "both"
    assert found["groups"] == ["l", "r"]
    assert found["delays"][0] == 0 < found["delays"][1]
    (wait,) = found["waits"]
    assert (wait["group"], wait["for_group"]) == ("r", "l")
    assert wait["delay"] == found["delays"][1]
    assert {body.partition("::")[0] for body in wait["pair"]} == {"l", "r"}
    # What is delivered is what was proven.
    motion = found["polynomial"]
    assert motion["breaks"][-1] == found["duration"]
    assert motion["joint_names"] == [f"{side}::joint_{k}" for side in "lr" for k in range(1, 7)]
    first, second = (client.get(f"/v1/plans/{one}").json()["result"] for one in (back[0], into[1]))
    begin = np.add(motion["bases"][0], motion["coefficients"][0][0])
    assert begin == pytest.approx([*first["start"], *second["start"]])


def test_plans_and_their_delays_give_the_motion_that_was_proven(client, app, two, crossing):
    """What an execution of several plans begins with."""
    into, back = crossing
    plans = [back[0], into[1]]
    found = post(client, two, plans, polynomial=True).json()["schedule"]

    async def combine():
        record = await app.state.scenes.get(two, None)
        motions = await planned_motions(app.state.jobs, record, plans)
        return combined_motion(record, motions, found["delays"])

    motion = client.portal.call(combine)
    assert motion.group == found["group"]
    assert motion.trajectory.model_dump(mode="json") == found["polynomial"]


def test_two_that_end_in_each_others_way_have_no_schedule(client, two, crossing):
    into, _ = crossing
    answer = post(client, two, into).json()
    assert answer["schedule"] is None
    failure = answer["failure"]
    assert failure["code"] == "schedule_not_found"
    assert failure["stage"] == "schedule"
    assert failure["evidence"]["groups"] == ["l", "r"]
    assert {body.partition("::")[0] for body in failure["evidence"]["pair"]} == {"l", "r"}


def test_faults_are_refused(client, two, crossing, scene, solved):
    into, back = crossing
    twice = post(client, two, [into[0], back[0]])
    assert twice.status_code == 422
    assert twice.json()["evidence"]["joint"] == "l::joint_1"
    assert twice.json()["evidence"]["field"] == "plans"
    unknown = post(client, two, [into[0], "plan_that_is_not_there"])
    assert unknown.status_code == 404
    elsewhere = post(client, two, [into[0], solved["id"]])
    assert elsewhere.status_code == 422
    assert elsewhere.json()["evidence"]["field"] == "plans.1"
    assert post(client, two, []).status_code == 422
