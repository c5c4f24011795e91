"""Groups that span robots, over HTTP: in every request that takes a group, and in scenes."""

import pytest

from tests.service.trajectories.test_schedule import TWO, inwards, plan

LOW = TWO["configurations"]["low"]["positions"]


@pytest.fixture(scope="module")
def two(client):
    answer = client.post("/v1/scenes", json=TWO)
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


def test_a_scene_lists_its_groups_with_their_members(client, two):
    scene = client.get(f"/v1/scenes/{two}").json()
    groups = {group["name"]: group for group in scene["groups"]}
    assert list(groups) == ["l", "r", "both"]
    assert groups["both"]["members"] == ["l", "r"]
    assert groups["both"]["aliases"] == ["l+r"]
    assert "members" not in groups["l"]
    assert groups["both"]["configurations"]["low"] == LOW
    assert groups["both"]["position_names"] == [
        *groups["l"]["position_names"],
        *groups["r"]["position_names"],
    ]
    assert scene["document"]["groups"] == {"both": ["l", "r"]}


@pytest.mark.parametrize("group", ["both", ["l", "r"], ["l::arm", "r"], "l+r"])
def test_both_arms_are_planned_for_as_one(client, two, group):
    found = plan(client, two, group, {"type": "configuration", "name": "low"})
    assert found["result"]["certificate"]["proven"]
    assert found["result"]["goal_configuration"] == pytest.approx(LOW)
    assert found["request"]["group"] == (
        "l::arm+r" if group == ["l::arm", "r"] else group if isinstance(group, str) else "l+r"
    )


def test_a_pose_of_one_tool_leaves_the_other_arm_where_it_is(client, two):
    goal = {**inwards("r"), "frame": "r::tcp"}
    found = plan(client, two, ["l", "r"], goal)
    assert found["result"]["goal_configuration"][:6] == pytest.approx(found["result"]["start"][:6])


def test_questions_take_them_too(client, two):
    check = {"group": ["r", "l"], "configurations": [[*LOW[6:], *LOW[:6]]]}
    answer = client.post(f"/v1/scenes/{two}/check", json=check)
    assert answer.status_code == 200, answer.text
    fk = {"group": ["l", "r"], "configurations": [LOW]}
    poses = client.post(f"/v1/scenes/{two}/fk", json=fk).json()["results"][0]
    assert {"l::tcp", "r::tcp"} <= set(poses)
    ik = {"group": "both", "goal": {**inwards("l"), "frame": "l::tcp"}}
    answer = client.post(f"/v1/scenes/{two}/ik", json=ik)
    assert answer.status_code == 200, answer.text
    path = {"scene": two, "group": ["l", "r"], "waypoints": [[0.0] * 12, LOW]}
    answer = client.post("/v1/trajectories/retime", json=path)
    assert answer.status_code == 200, answer.text
    assert answer.json()["certificate"]["proven"]


FAULTS = [
    (["l", "q"], "/group/1", ["r"]),
    (["l", "bot"], "/group/1", ["both"]),
    ("l+bot", "/group", ["both"]),
    (["bot"], "/group/0", ["both"]),
]


@pytest.mark.parametrize(("group", "pointer", "nearest"), FAULTS)
def test_members_that_do_not_exist_are_named(client, two, group, pointer, nearest):
    body = {"group": group, "configurations": [LOW]}
    refused = client.post(f"/v1/scenes/{two}/check", json=body)
    assert refused.status_code == 422
    assert refused.json()["code"] == "unknown_name"
    (error,) = refused.json()["errors"]
    assert error["pointer"] == pointer
    if pointer != "/group/1" or group[1] == "bot":
        assert error["nearest"] == nearest


def test_a_joint_of_two_members_is_named(client, two):
    for group in (["l", "l"], ["both", "l"], "l+l::arm"):
        body = {"group": group, "configurations": [LOW]}
        refused = client.post(f"/v1/scenes/{two}/check", json=body)
        assert refused.status_code == 422, refused.text
        assert refused.json()["evidence"]["joint"] == "l::joint_1"
        assert "l::joint_1" in refused.json()["detail"]


def test_faults_of_a_scene_have_a_pointer(client):
    scene = {**TWO, "groups": {"both": ["l", "x"]}}
    refused = client.post("/v1/scenes", json=scene)
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["pointer"] == "/groups/both/1"


@pytest.mark.parametrize("group", [[], [1], {"a": 1}, None, [["l"]], ""])
def test_what_is_no_group_is_refused(client, two, group):
    body = {"group": group, "configurations": [LOW]}
    refused = client.post(f"/v1/scenes/{two}/check", json=body)
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["pointer"].startswith("/group")
