"""Different robots of a scene move at the same time, as far as that is proven."""

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


def moving(client, scene, robot, **fields):
    """The id of an execution that moves."""
    plan = planned(client, scene, robot)
    execution = execute(client, plan=plan, speed=0.02, **fields).json()["id"]
    begun(client, execution)
    return execution


@pytest.mark.parametrize("order", ["ab", pytest.param("ba", marks=only_campaign("3 s"))])
def test_two_robots_are_not_executed_into_each_other(client, scene, order):
    """Both plans hold while the other robot stands; they have met 52 mm deep."""
    first, second = (planned(client, scene, robot) for robot in order)
    slow = execute(client, plan=first, speed=0.02, driver="simulated").json()["id"]
    refused = execute(client, plan=second, driver="simulated")
    assert (refused.status_code, refused.json()["code"]) == (409, "not_certified")
    evidence = refused.json()["evidence"]
    assert (evidence["check"], evidence["execution"]) == ("beside", slow)
    assert evidence["pair"] == [f"{robot}::body" for robot in reversed(order)]
    assert evidence["value"] < evidence["bound"]
    # Where it says they meet they do.
    q = {
        robot: place(client, plan, at)
        for robot, plan, at in (
            (order[1], second, evidence["time"]),
            (order[0], first, evidence["other_time"]),
        )
    }
    question = {"group": "a+b", "configurations": [[*q["a"], *q["b"]]]}
    check = client.post(f"/v1/scenes/{scene}/check", json=question).json()["results"][0]
    assert not check["valid"]
    client.post(f"/v1/executions/{slow}/speed", json={"speed": 100})
    assert ended(client, slow)["state"] == "succeeded"
    done = execute(client, wait=60, plan=second, speed=50, driver="simulated").json()
    assert (done["state"], done["status"]["contacts"]) == ("succeeded", [])


def place(client, plan, time):
    """Where a plan's motion is at a time, by its nearest sample."""
    motion = client.get(f"/v1/plans/{plan}").json()["result"]["trajectory"]
    at = min(range(len(motion["times"])), key=lambda i: abs(motion["times"][i] - time))
    return motion["positions"][at]


def test_robots_that_cannot_meet_move_at_the_same_time(client, scene):
    one = moving(client, scene, "b")
    two = moving(client, scene, "c")
    robots = client.get(f"/v1/scenes/{scene}/state").json()["robots"]
    told = {each["robot"]: (each["status"], each["execution"]) for each in robots}
    assert told == {"a": ("at_rest", None), "b": ("moving", one), "c": ("moving", two)}
    for execution in (one, two):
        client.post(f"/v1/executions/{execution}/speed", json={"speed": 100})
    for execution in (one, two):
        assert ended(client, execution)["state"] == "succeeded"
    found = where(client, scene)
    assert found["b"] == status(client, one)["positions"] == pytest.approx(GOALS["b"], abs=0.005)
    assert found["c"] == status(client, two)["positions"] == pytest.approx(GOALS["c"], abs=0.005)


@only_campaign("2 s")
def test_what_is_behind_a_robot_counts_as_it_can_be_driven_backwards(client, scene):
    """The second robot crosses where the first one has been: that may come back."""
    execution = moving(client, scene, "a")
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 0.3})
    while status(client, execution)["progress"] < 0.6:
        pass
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 0})
    refused = execute(client, plan=planned(client, scene, "b"))
    assert refused.json()["evidence"]["execution"] == execution
    client.post(f"/v1/executions/{execution}/cancel")
    ended(client, execution)
    # Where it rests now, it is out of the way.
    plan = planned(client, scene, "b")
    assert execute(client, wait=60, plan=plan, speed=50).json()["state"] == "succeeded"


@only_campaign("1.3 s")
def test_one_that_holds_several_robots_is_in_the_way_of_each(client, scene):
    plans = [planned(client, scene, robot) for robot in "ab"]
    both = execute(client, plans=plans, speed=0.02).json()["id"]
    begun(client, both)
    for plan in plans:
        busy = execute(client, plan=plan)
        assert (busy.status_code, busy.json()["code"]) == (409, "robot_busy")
        assert busy.json()["evidence"] == {"execution": both, "group": "a+b"}
    third = moving(client, scene, "c")
    for execution in (both, third):
        client.post(f"/v1/executions/{execution}/cancel")
        assert ended(client, execution)["state"] == "canceled"


def test_one_that_may_go_on_with_another_motion_has_all_robots(client, scene):
    """What was proven beside its motion is not proven beside the next one."""
    one, other = planned(client, scene, "b"), planned(client, scene, "c")
    execution = execute(client, plan=one, speed=0.02, on_conflict="replan").json()["id"]
    begun(client, execution)
    busy = execute(client, plan=other)
    assert (busy.status_code, busy.json()["code"]) == (409, "robot_busy")
    client.post(f"/v1/executions/{execution}/cancel")
    ended(client, execution)
    third = moving(client, scene, "c")
    refused = execute(client, plan=planned(client, scene, "b"), on_conflict="replan")
    assert (refused.status_code, refused.json()["code"]) == (409, "robot_busy")
    client.post(f"/v1/executions/{third}/cancel")
    assert ended(client, third)["state"] == "canceled"


@only_campaign("2 s")
def test_an_edit_is_judged_for_each_and_with_the_others_in_mind(client, scene):
    one, two = moving(client, scene, "b"), moving(client, scene, "c")
    told = edited(client, scene, box("far", [3, 3, 0]))["executions"]
    assert {(each["id"], each["verdict"]) for each in told} == {
        (one, "unaffected"),
        (two, "unaffected"),
    }
    [stopped] = [
        each
        for each in edited(client, scene, box("late", [0.0, 0.4, 0.0]))["executions"]
        if each["verdict"] == "conflict"
    ]
    assert (stopped["id"], stopped["check"]) == (one, "clearance")
    assert ended(client, one)["failure"]["code"] == "path_blocked"
    client.post(f"/v1/executions/{two}/cancel")


@only_campaign("3 s")
def test_two_that_may_not_meet_any_more_rest_at_once_until_they_may_again(client, scene):
    """Where they would meet first is not known, so neither goes on to where they may meet."""
    pair = {"pair": ["a::body", "b::body"]}
    edited(client, scene, {"op": "allow", **pair})
    both = [moving(client, scene, robot, on_conflict="slow") for robot in "ab"]
    told = edited(client, scene, {"op": "forbid", **pair})["executions"]
    assert {each["check"] for each in told} == {"beside"}
    before = [status(client, each)["time"] for each in both]
    for execution, time in zip(both, before, strict=True):
        client.post(f"/v1/executions/{execution}/speed", json={"speed": 20})
        while status(client, execution)["path_velocity"]:
            pass
        resting = status(client, execution)
        assert resting["state"] == "executing"
        assert resting["time"] < time + 0.1
    told = edited(client, scene, {"op": "allow", **pair})["executions"]
    assert {each["verdict"] for each in told} == {"unaffected"}
    assert [ended(client, each)["state"] for each in both] == ["succeeded", "succeeded"]


def test_an_edit_by_which_two_may_not_meet_any_more_stops_both(client, scene):
    edited(client, scene, {"op": "allow", "pair": ["a::body", "b::body"]})
    one, two = moving(client, scene, "a"), moving(client, scene, "b")
    told = edited(client, scene, {"op": "forbid", "pair": ["a::body", "b::body"]})["executions"]
    found = {(each["id"], each["check"], each["other"]) for each in told}
    assert found == {(one, "beside", two), (two, "beside", one)}
    for execution, other in ((one, two), (two, one)):
        failure = ended(client, execution)["failure"]
        assert (failure["code"], failure["evidence"]["execution"]) == ("path_blocked", other)
