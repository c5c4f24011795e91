"""Executions wait for their robots on request: they begin in order, and are proven then."""

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
    where,
)

NEAR = [-0.3, 0.0, 0.0]


@pytest.fixture
def scene(client):
    return posted(client)


@pytest.fixture
def first(client, scene):
    """An execution of the first robot that moves."""
    execution = execute(client, plan=planned(client, scene, "a", NEAR), speed=0.02).json()["id"]
    begun(client, execution)
    return execution


def waits(client, **fields):
    """The id of an execution that waits for its robots."""
    answer = execute(client, when_busy="wait", speed=50, **fields)
    assert answer.status_code == 202, answer.text
    told = answer.json()
    assert (told["state"], told["is_waiting"], told["started_at"]) == ("accepted", True, None)
    return told["id"]


def onward(client, scene, robot="a", start=NEAR, goal=None):
    """A plan from where a robot will be."""
    return planned(client, scene, robot, goal, start=start)


def finish(client, execution):
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 100})
    assert ended(client, execution)["state"] == "succeeded"


@only_campaign("2 s")
def test_it_begins_where_the_one_before_has_ended(client, scene, first):
    plan = onward(client, scene)
    refused = execute(client, plan=plan)
    assert (refused.status_code, refused.json()["code"]) == (409, "robot_busy")
    second = waits(client, plan=plan)
    finish(client, first)
    done = ended(client, second)
    assert (done["state"], done["is_waiting"]) == ("succeeded", False)
    before = client.get(f"/v1/executions/{first}").json()
    assert done["started_at"] >= before["finished_at"]
    assert where(client, scene)["a"] == done["status"]["positions"]
    assert done["status"]["positions"] == pytest.approx(GOALS["a"], abs=0.005)


def test_the_order_of_requests_is_kept_for_each_robot(client, scene, first):
    there = onward(client, scene)
    second = waits(client, plan=there)
    third = waits(client, plan=onward(client, scene, start=GOALS["a"], goal=NEAR))
    # Another robot does not wait for it; one that holds both does.
    other = execute(client, wait=60, plan=planned(client, scene, "c"), speed=50).json()
    assert other["state"] == "succeeded"
    behind = execute(client, plan=there)
    assert behind.json()["code"] == "robot_busy"
    finish(client, first)
    begins = [ended(client, each) for each in (second, third)]
    assert [each["state"] for each in begins] == ["succeeded", "succeeded"]
    assert begins[0]["finished_at"] <= begins[1]["started_at"]
    assert where(client, scene)["a"] == pytest.approx(NEAR, abs=0.005)


@only_campaign("1.3 s")
def test_one_of_several_robots_waits_for_all_of_them(client, scene, first):
    plans = [onward(client, scene), planned(client, scene, "c")]
    both = waits(client, plans=plans)
    # It is next for the other robot, too: nothing overtakes it.
    busy = execute(client, plan=plans[1])
    assert busy.json()["evidence"] == {"execution": both, "group": "a+c"}
    finish(client, first)
    done = ended(client, both)
    assert (done["state"], done["delays"]) == ("succeeded", [0.0, 0.0])


def test_it_is_held_against_the_scene_and_the_robot_as_they_are_then(client, scene, first):
    plan = onward(client, scene)
    blocked = waits(client, plan=plan)
    after = waits(client, plan=plan)
    told = edited(client, scene, box("late", [0.0, 0.0, 0.0]))["executions"]
    assert [each["id"] for each in told] == [first]
    finish(client, first)
    failure = ended(client, blocked)["failure"]
    assert (failure["code"], failure["evidence"]["check"]) == ("not_certified", "clearance")
    assert "late" in failure["evidence"]["pair"]
    assert ended(client, after)["state"] == "aborted"
    elsewhere = execute(client, plan=planned(client, scene, "c"), speed=0.02).json()["id"]
    begun(client, elsewhere)
    wrong = waits(client, plan=planned(client, scene, "c"))
    finish(client, elsewhere)
    done = ended(client, wrong)
    assert (done["state"], done["failure"]["code"]) == ("aborted", "start_mismatch")
    assert (done["status"], done["started_at"]) == (None, None)


@only_campaign("1.4 s")
def test_canceled_while_it_waits_it_never_begins(client, scene, first):
    second = waits(client, plan=onward(client, scene))
    third = waits(client, plan=onward(client, scene))
    assert client.post(f"/v1/executions/{second}/cancel").json()["state"] == "canceled"
    finish(client, first)
    assert ended(client, third)["state"] == "succeeded"
    done = ended(client, second)
    assert (done["state"], done["started_at"], done["status"]) == ("canceled", None, None)
    assert client.delete(f"/v1/executions/{second}").status_code == 204


@only_campaign("1 s")
def test_it_is_steered_while_it_waits(client, scene, first):
    second = waits(client, plan=onward(client, scene))
    assert client.post(f"/v1/executions/{second}/pause").status_code == 200
    finish(client, first)
    while client.get(f"/v1/executions/{second}").json()["state"] != "paused":
        pass
    client.post(f"/v1/executions/{second}/resume")
    assert ended(client, second)["state"] == "succeeded"


@only_campaign("1 s")
def test_a_motion_of_ones_own_waits_too(client, scene, first):
    motion = client.get(f"/v1/plans/{onward(client, scene)}").json()["result"]["trajectory"]
    wanted = ("times", "positions", "velocities", "accelerations")
    own = {"scene": scene, "group": "a", "trajectory": {name: motion[name] for name in wanted}}
    second = waits(client, trajectory=own)
    finish(client, first)
    assert ended(client, second)["state"] == "succeeded"


@only_campaign("1 s")
def test_with_robots_that_are_free_nothing_waits(client, scene):
    plan = planned(client, scene, "a", NEAR)
    done = execute(client, wait=60, plan=plan, speed=50, when_busy="wait").json()
    assert (done["state"], done["is_waiting"]) == ("succeeded", False)
