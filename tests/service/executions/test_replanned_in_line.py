"""Executions that wait for their robots, and are planned anew where their motion does not hold."""

import pytest

from tests.service.executions.crossing import GOALS, box, edited, ended, planned
from tests.service.executions.test_waiting_line import (  # noqa: F401  (fixtures)
    finish,
    first,
    onward,
    scene,
    waits,
)

REPLAN = {"on_not_certified": "replan"}


def test_from_where_its_robot_has_come_to_it_goes_to_the_same_goal(client, scene, first):  # noqa: F811
    plan = planned(client, scene, "a")  # from where the robot is not when its turn comes
    second = waits(client, plan=plan, **REPLAN)
    behind = waits(client, plan=onward(client, scene, start=GOALS["a"], goal=[0.3, 0.0, 0.0]))
    assert not client.get(f"/v1/executions/{second}").json()["replanned"]
    finish(client, first)
    done = ended(client, second)
    assert done["state"] == "succeeded", done["failure"]
    assert done["replanned"]["code"] == "start_mismatch"
    assert done["replanned"]["plan"] != plan
    assert done["request"]["plan"] == plan
    assert done["status"]["positions"] == pytest.approx(GOALS["a"], abs=0.005)
    # What waited behind it kept its place.
    after = ended(client, behind)
    assert after["state"] == "succeeded", after["failure"]
    assert (after["replanned"], done["finished_at"] <= after["started_at"]) == (None, True)


def test_around_what_came_into_its_way_while_it_waited(client, scene, first):  # noqa: F811
    second = waits(client, plan=onward(client, scene), **REPLAN)
    edited(client, scene, box("late", [0.0, 0.0, 0.0]))
    finish(client, first)
    done = ended(client, second)
    assert done["state"] == "succeeded", done["failure"]
    assert done["replanned"]["code"] == "not_certified"
    assert done["status"]["positions"] == pytest.approx(GOALS["a"], abs=0.005)


def test_without_a_plan_it_ends_with_the_refusal_and_the_line_goes_on(client, scene, first):  # noqa: F811
    second = waits(client, plan=onward(client, scene), **REPLAN)
    edited(client, scene, box("late", GOALS["a"]))
    behind = waits(client, plan=planned(client, scene, "a", [-0.35, 0.0, 0.0]), **REPLAN)
    finish(client, first)
    done = ended(client, second)
    assert (done["state"], done["failure"]["code"]) == ("aborted", "not_certified")
    assert done["failure"]["evidence"]["replanned"]["failure"]["code"] == "goal_in_collision"
    assert done["started_at"] is None
    after = ended(client, behind)
    assert (after["state"], after["replanned"]["code"]) == ("succeeded", "start_mismatch")


def test_canceled_while_it_is_planned_it_never_begins(client, scene, first):  # noqa: F811
    second = waits(client, plan=planned(client, scene, "a"), **REPLAN)
    third = waits(client, plan=planned(client, scene, "a"), **REPLAN)
    client.post(f"/v1/executions/{first}/speed", json={"speed": 100})
    assert client.post(f"/v1/executions/{second}/cancel").json()["state"] in {
        "canceled",
        "canceling",
    }
    done = ended(client, third)
    assert done["state"] == "succeeded", done["failure"]
