"""`on_conflict: replan`: the robot goes on with another motion around what came into its way."""

import numpy as np
import pytest

from service.client.events import decode_events
from tests.profiles import only_campaign
from tests.service.executions.test_stale_executions import (
    ARM,
    aside,
    edit,
    planned,
    posted,
    tool_pose,
)
from tests.service.executions.test_verdicts import box, ended, status


def swinging(client, turn=1.5, **fields):
    """A scene, a plan that swings the arm aside, and an execution of it that moves."""
    scene = posted(client, ARM)
    plan = planned(client, scene, aside(scene, turn))
    given = {"plan": plan["id"], "speed": 0.03, "on_conflict": "replan", **fields}
    execution = client.post("/v1/executions", json=given).json()["id"]
    while not (status(client, execution) or {}).get("time"):
        pass
    return scene, plan, execution


def in_the_way(client, scene, plan, size=0.06):
    """A box where the tool is half way."""
    rows = plan["result"]["trajectory"]["positions"]
    middle = tool_pose(client, scene, rows[len(rows) // 2])["position"].tolist()
    return box("late", middle, size)


def gone_on(client, execution):
    """The execution once it has gone on with another motion."""
    while not (now := client.get(f"/v1/executions/{execution}").json())["motions"]:
        assert now["state"] == "executing", now["failure"]
    return now


def events_of(client, execution):
    """All events of an execution that has ended."""
    with client.stream("GET", f"/v1/executions/{execution}/events") as stream:
        return list(decode_events(stream))


def assert_clear(client, scene, events):
    """Assert that the robot was nowhere in collision, by its measured positions."""
    rows = [event.data["positions"] for event in events if event.type == "status"]
    body = {"group": "arm", "configurations": rows}
    found = client.post(f"/v1/scenes/{scene['id']}/check", json=body).json()["results"]
    assert all(each["valid"] for each in found)


def test_it_goes_around_what_came_into_its_way_without_a_rest(client):
    scene, plan, execution = swinging(client, driver="kinematic")
    [verdict] = edit(client, scene, in_the_way(client, scene, plan))["executions"]
    assert (verdict["verdict"], verdict["action"]) == ("conflict", "replan")
    at_once = gone_on(client, execution)
    assert at_once["status"]["path_velocity"] > 0.0
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 20})
    done = ended(client, execution)
    assert done["state"] == "succeeded", done["failure"]
    [followed] = done["motions"]
    assert (followed["number"], followed["is_spliced"]) == (1, True)
    assert done["status"]["motion"] == 1
    assert 0 < followed["left_at"] < verdict["time"]
    goal = plan["result"]["trajectory"]["positions"][-1]
    np.testing.assert_allclose(done["status"]["positions"], goal, atol=0.01)
    events = events_of(client, execution)
    assert_clear(client, scene, events)
    [told] = [event.data for event in events if event.type == "motion"]
    assert told["trajectory"]["breaks"][-1] == pytest.approx(followed["duration"])
    assert client.get(f"/v1/plans/{followed['plan']}").json()["state"] == "succeeded"


def test_without_a_way_it_stops_as_ever(client):
    scene, plan, execution = swinging(client, driver="kinematic")
    rows = plan["result"]["trajectory"]["positions"]
    goal = tool_pose(client, scene, rows[-1])["position"].tolist()
    [verdict] = edit(client, scene, box("late", goal))["executions"]
    assert verdict["action"] == "replan"
    done = ended(client, execution)
    assert (done["state"], done["failure"]["code"]) == ("aborted", "path_blocked")
    assert done["motions"] == []


@only_campaign("it comes to rest, and waits for a second plan: 5 s")
def test_where_no_splice_is_proven_it_begins_anew_from_rest(client, monkeypatch):
    monkeypatch.setattr("service.executions.proofs.splice._ALLOWED", 0.0)
    scene, plan, execution = swinging(client, driver="kinematic", speed=0.3)
    [verdict] = edit(client, scene, in_the_way(client, scene, plan))["executions"]
    assert verdict["action"] == "replan"
    done = ended(client, execution)
    assert done["state"] == "succeeded", done["failure"]
    [followed] = done["motions"]
    assert not followed["is_spliced"]
    assert_clear(client, scene, events_of(client, execution))


@only_campaign("physics at a tenth of its pace: 10 s")
def test_the_next_edit_is_about_the_motion_that_is_followed_by_then(client):
    scene, plan, execution = swinging(client, driver="simulated")
    late = in_the_way(client, scene, plan)
    edit(client, scene, late)
    gone_on(client, execution)
    # what was in the way of the first motion only is in no way any more
    [same] = edit(client, scene, box("far", [3.0, 3.0, 0.5]))["executions"]
    assert same["verdict"] == "unaffected"
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 1})
    done = ended(client, execution)
    assert done["state"] == "succeeded", done["failure"]
    assert done["status"]["contacts"] == []
    assert len(done["motions"]) == 1
    # a spliced motion has what was passed of the one before: it is replayed alone
    page = client.get(f"/v1/scenes/{scene['id']}/replay.html")
    assert page.status_code == 200
