"""`on_not_certified: replan`: a motion that does not hold any more is planned anew, and told so."""

from tests.service.executions.test_replanning import in_the_way
from tests.service.executions.test_stale_executions import (
    ARM,
    aside,
    edit,
    executed,
    planned,
    posted,
    tool_pose,
)
from tests.service.executions.test_verdicts import box


def test_what_came_into_the_way_before_is_planned_around(client):
    scene = posted(client, ARM)
    plan = planned(client, scene, aside(scene, 1.5))
    edit(client, scene, in_the_way(client, scene, plan))
    terms = {"driver": "kinematic", "on_not_certified": "replan"}
    assert executed(client, plan, driver="kinematic").json()["code"] == "not_certified"
    done = executed(client, plan, **terms).json()
    assert done["state"] == "succeeded", done
    assert done["request"]["plan"] == plan["id"]
    assert done["replanned"]["code"] == "not_certified"
    assert done["replanned"]["plan"] != plan["id"]
    # from the end, where the first plan does not begin: the same goal, in no time
    again = executed(client, plan, **terms).json()
    assert again["state"] == "succeeded", again
    assert again["replanned"]["code"] == "start_mismatch"


def test_a_motion_that_holds_is_carried_out_as_it_is(client):
    scene = posted(client, ARM)
    plan = planned(client, scene, aside(scene))
    done = executed(client, plan, driver="kinematic", on_not_certified="replan").json()
    assert (done["state"], done["replanned"]) == ("succeeded", None)


def test_without_a_plan_it_is_refused_as_ever(client):
    scene = posted(client, ARM)
    plan = planned(client, scene, aside(scene, 1.5))
    last = plan["result"]["trajectory"]["positions"][-1]
    goal = tool_pose(client, scene, last)["position"].tolist()
    edit(client, scene, box("late", goal))
    answer = executed(client, plan, on_not_certified="replan")
    assert (answer.status_code, answer.json()["code"]) == (409, "not_certified")
    assert answer.json()["evidence"]["replanned"]["failure"]["code"] == "goal_in_collision"
