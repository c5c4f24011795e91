"""Several plans are carried out as one motion with one clock."""

import pytest

from tests.profiles import only_campaign
from tests.service.executions.crossing import (
    GOALS,
    begun,
    box,
    edited,
    ended,
    execute,
    planned,
    posted,
    status,
    where,
)


@pytest.fixture
def scene(client):
    return posted(client)


@pytest.fixture
def plans(client, scene):
    return [planned(client, scene, robot) for robot in "ab"]


@pytest.fixture
def slow(client, scene, plans):
    """An execution of both plans that moves."""
    execution = execute(client, plans=plans, speed=0.05).json()["id"]
    begun(client, execution)
    return execution


def test_plans_that_cross_are_carried_out_with_the_smallest_delays(client, scene, plans):
    answer = execute(client, wait=60, plans=plans, driver="simulated", speed=50)
    assert answer.status_code == 200, answer.text
    done = answer.json()
    assert (done["state"], done["group"]) == ("succeeded", "a+b")
    schedule = {"scene": scene, "plans": plans}
    edited(client, scene, *(back(robot) for robot in "ab"))
    found = client.post("/v1/trajectories/schedule", json=schedule).json()["schedule"]
    assert done["delays"] == found["delays"]
    assert done["delays"][0] == 0.0 < done["delays"][1]
    assert done["request"]["plans"] == plans
    assert done["status"]["contacts"] == []
    assert done["status"]["time"] == pytest.approx(found["duration"], abs=0.01)


def back(robot):
    place = {"a": [-0.4, 0.0, 0.0], "b": [0.0, -0.4, 0.0]}[robot]
    return {"op": "set_positions", "robot": robot, "positions": place}


@only_campaign("1 s")
def test_both_robots_are_where_they_were_measured_last(client, scene, plans):
    done = execute(client, wait=60, plans=plans, speed=50).json()
    measured = done["status"]["positions"]
    assert where(client, scene) == {"a": measured[:3], "b": measured[3:], "c": [0.4, -0.45, 0.0]}
    assert measured == pytest.approx([*GOALS["a"], *GOALS["b"]], abs=0.005)


@only_campaign("3 s")
def test_delays_that_are_given_are_kept_or_refused(client, scene, plans):
    refused = execute(client, plans=plans, delays=[0.0, 0.0])
    assert (refused.status_code, refused.json()["code"]) == (409, "not_certified")
    evidence = refused.json()["evidence"]
    assert evidence["check"] == "clearance"
    assert {body.partition("::")[0] for body in evidence["pair"]} == {"a", "b"}
    late = [9.0, 0.5]
    done = execute(client, wait=60, plans=plans, delays=late, speed=100).json()
    assert (done["state"], done["delays"]) == ("succeeded", late)


@only_campaign("1 s")
def test_commands_are_of_all_robots(client, scene, plans, slow):
    client.post(f"/v1/executions/{slow}/pause")
    while status(client, slow)["path_velocity"]:
        pass
    resting = where(client, scene)
    client.post(f"/v1/executions/{slow}/speed", json={"speed": -20})
    client.post(f"/v1/executions/{slow}/resume")
    while status(client, slow)["time"] > 0:
        pass
    # One that waits for the other has not moved yet.
    assert where(client, scene) != resting
    at_start = [*back("a")["positions"], *back("b")["positions"]]
    assert status(client, slow)["positions"] == pytest.approx(at_start, abs=1e-6)
    client.post(f"/v1/executions/{slow}/cancel")
    assert ended(client, slow)["state"] == "canceled"


@only_campaign("1 s")
def test_what_comes_into_the_way_of_one_stops_all(client, scene, slow):
    for obstacle, verdict in (
        (box("far", [3, 3, 0]), "unaffected"),
        (box("late", [0.0, 0.4, 0]), "conflict"),
    ):
        [found] = edited(client, scene, obstacle)["executions"]
        assert (found["id"], found["verdict"]) == (slow, verdict)
    assert "late" in found["pair"]
    done = ended(client, slow)
    assert (done["state"], done["failure"]["code"]) == ("aborted", "path_blocked")


@only_campaign("1 s")
def test_what_one_plan_was_asked_to_keep_is_kept(client, scene):
    """A post is nearer to the way of the first robot than its plan allows, and than no other's."""
    plans = [planned(client, scene, "a", margin=0.05), planned(client, scene, "c")]
    edited(client, scene, box("post", [0.0, 0.13, 0.05]))
    refused = execute(client, plans=plans, delays=[0.0, 0.0])
    assert refused.json()["code"] == "not_certified"
    assert "post" in refused.json()["evidence"]["pair"]
    edited(client, scene, {"op": "remove", "object": "post"})
    assert execute(client, wait=60, plans=plans, speed=50).json()["state"] == "succeeded"


@only_campaign("1.3 s")
def test_a_constraint_of_one_plan_is_kept_where_it_is_by_now(client, scene):
    """A place that one robot keeps out of hangs a metre below a lamp, which is moved."""
    lamp = box("lamp", [3.0, 3.0, 1.0])
    lamp["object"]["movable"] = True
    edited(client, scene, lamp)
    below = {"size": [0.1, 0.1, 0.2], "pose": {"position": [0.0, 0.0, -1.0], "frame": "lamp"}}
    keep_out = {"type": "keep_out", "frame": "a::body", "box": below}
    plans = [planned(client, scene, "a", path_constraints=[keep_out]), planned(client, scene, "c")]
    moved = {"op": "move", "object": "lamp", "pose": {"position": [0.0, 0.0, 1.0]}}
    edited(client, scene, moved)
    refused = execute(client, plans=plans)
    assert (refused.status_code, refused.json()["code"]) == (409, "not_certified")
    assert refused.json()["evidence"]["check"] != "clearance"
    edited(client, scene, moved | {"pose": {"position": [3.0, 3.0, 1.0]}})
    moving = execute(client, plans=plans, speed=0.02).json()["id"]
    begun(client, moving)
    [verdict] = edited(client, scene, moved)["executions"]
    assert (verdict["verdict"], verdict["check"]) == (
        "conflict",
        refused.json()["evidence"]["check"],
    )
    assert ended(client, moving)["failure"]["code"] == "path_blocked"


def test_faults_are_refused_at_their_place(client, scene, plans):
    twice = execute(client, plans=[*plans, planned(client, scene, "a")])
    assert (twice.status_code, twice.json()["code"]) == (422, "problem_invalid")
    assert [each["pointer"] for each in twice.json()["errors"]] == ["/plans/2"]
    elsewhere = execute(client, plans=[plans[0], planned(client, posted(client), "b")])
    assert [each["pointer"] for each in elsewhere.json()["errors"]] == ["/plans/1"]
    for wrong in (
        {"plans": []},
        {"plans": plans, "plan": plans[0]},
        {"plans": plans, "delays": [0]},
    ):
        assert execute(client, **wrong).status_code == 422
    assert execute(client, plan=plans[0], delays=[0.0]).status_code == 422
    moved = execute(client, wait=60, plan=plans[0], speed=50).json()
    assert moved["state"] == "succeeded"
    assert execute(client, plans=plans).json()["code"] == "start_mismatch"
