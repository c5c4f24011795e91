"""`on_conflict: slow`: the robot rests before what came into its way, until it is gone."""

from tests.profiles import only_campaign
from tests.service.executions.test_stale_executions import (
    ARM,
    aside,
    edit,
    planned,
    posted,
    tool_pose,
)
from tests.service.executions.test_verdicts import begun, box, ended, moved, status  # noqa: F401


def at_rest(client, execution):
    """The status of an execution that waits on its path."""
    while (now := status(client, execution))["path_velocity"] or now["ahead"] is None:
        assert now["state"] == "executing"
    return now


def test_the_robot_rests_before_a_conflict_and_goes_on_once_it_is_gone(client, moved):  # noqa: F811
    _, place = moved
    scene, execution = begun(client, moved[0], on_conflict="slow", driver="kinematic")
    [verdict] = edit(client, scene, box("late", place(0.7)))["executions"]
    assert (verdict["verdict"], verdict["action"]) == ("conflict", "slow")
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 20})
    waiting = at_rest(client, execution)
    assert waiting["ahead"] == verdict["time"]
    assert verdict["time"] - 0.05 < waiting["time"] <= verdict["time"]
    check = {"group": "arm", "configurations": [waiting["positions"]]}
    found = client.post(f"/v1/scenes/{scene['id']}/check", json=check).json()["results"]
    assert [each["valid"] for each in found] == [True]
    # another edit beside it changes nothing, the end of the conflict does
    [same] = edit(client, scene, box("far", [3.0, 3.0, 0.5]))["executions"]
    assert same["verdict"] == "conflict"
    [free] = edit(client, scene, {"op": "remove", "object": "late"})["executions"]
    assert (free["verdict"], free["action"]) == ("unaffected", None)
    done = ended(client, execution)
    assert done["state"] == "succeeded", done["failure"]
    assert done["status"]["ahead"] is None


@only_campaign("3 s")
def test_what_came_behind_the_robot_is_not_met_on_the_way_back(client):
    scene = posted(client, ARM)
    plan = planned(client, scene, aside(scene, turn=2.0))
    given = {"plan": plan["id"], "driver": "kinematic", "on_conflict": "stop"}
    execution = client.post("/v1/executions", json=given).json()["id"]
    half = plan["result"]["trajectory"]["duration"] / 2
    while ((now := status(client, execution)) or {"time": 0.0})["time"] < half:
        assert now is None or now["state"] in {"accepted", "executing"}
    client.post(f"/v1/executions/{execution}/pause")
    first = plan["result"]["trajectory"]["positions"][0]
    behind = tool_pose(client, scene, first)["position"].tolist()
    [verdict] = edit(client, scene, box("behind", behind, 0.02))["executions"]
    assert verdict["verdict"] == "unaffected"
    client.post(f"/v1/executions/{execution}/speed", json={"speed": -1})
    client.post(f"/v1/executions/{execution}/resume")
    while (now := status(client, execution))["time"] - (now["behind"] or 0.0) > 0.05:
        assert now["state"] in {"executing", "paused"}
    assert now["behind"] > 0.05
    edit(client, scene, {"op": "remove", "object": "behind"})
    while (now := status(client, execution))["time"] > 0:
        assert now["state"] == "executing"
    assert now["behind"] is None
    client.post(f"/v1/executions/{execution}/cancel")
    assert ended(client, execution)["state"] == "canceled"


def test_a_verdict_that_did_not_come_in_time_is_sought_again(client, moved, monkeypatch):  # noqa: F811
    scene, execution = begun(client, moved[0], on_conflict="slow", driver="kinematic")
    with monkeypatch.context() as busy:  # so much that nothing is proven
        busy.setattr("service.executions.proofs.recheck._ALLOWED", 0.0)
        [verdict] = edit(client, scene, box("far", [3.0, 3.0, 0.5]))["executions"]
        assert (verdict["verdict"], verdict["check"]) == ("conflict", "undecided")
        at_rest(client, execution)
    client.post(f"/v1/executions/{execution}/speed", json={"speed": 20})
    done = ended(client, execution)  # without another edit
    assert done["state"] == "succeeded", done["failure"]
    assert done["status"]["ahead"] is None
