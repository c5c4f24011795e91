"""Questions to a scene over HTTP."""

import numpy as np
import pytest

HOME = "home"


@pytest.fixture(scope="module")
def group(client, scene):
    return client.get(f"/v1/scenes/{scene}").json()["groups"][0]


def ask(client, scene, what, **body):
    return client.post(f"/v1/scenes/{scene}/{what}", json={"group": "arm", **body})


def test_check_names_every_colliding_pair_with_its_depth(client, scene, group):
    home = group["configurations"]["home"]
    stretched = [0.0] * 6
    answer = ask(client, scene, "check", configurations=[home, stretched])
    free, hit = answer.json()["results"]
    assert free["valid"]
    assert free["collisions"] == []
    assert free["nearest"]["distance"] == free["distance"] > 0
    assert not hit["valid"]
    assert hit["collisions"]
    for pair in hit["collisions"]:
        gap = np.linalg.norm(np.subtract(*pair["points"]))
        assert pair["depth"] == pytest.approx(-pair["distance"]) == pytest.approx(gap, abs=1e-6)
    assert "post" in {body for pair in hit["collisions"] for body in pair["bodies"]}


def test_check_names_violated_limits(client, scene, group):
    outside = [*group["configurations"]["home"]]
    outside[2] = 9.0
    verdict = ask(client, scene, "check", configurations=[outside]).json()["results"][0]
    assert not verdict["valid"]
    assert [entry["joint"] for entry in verdict["limit_violations"]] == ["arm::elbow_joint"]
    assert verdict["limit_violations"][0]["upper"] < 9.0


def test_a_margin_makes_near_pairs_collide(client, scene, group):
    home = group["configurations"]["home"]
    distance = ask(client, scene, "check", configurations=[home]).json()["results"][0]["distance"]
    answer = ask(client, scene, "check", configurations=[home], margin=distance + 0.01).json()
    assert isinstance(answer["results"][0]["collisions"], list)


def test_ik_solutions_bring_the_tool_to_the_pose(client, scene):
    pose = {"position": [0, 0, 0], "rpy": [np.pi, 0, 0], "frame": "above"}
    goal = {"type": "pose", "poses": [pose]}
    found = ask(client, scene, "ik", goal=goal, seed=1).json()
    assert found["failure"] is None
    assert found["funnel"]["tried"] >= found["funnel"]["converged"] >= 1
    configurations = [entry["positions"] for entry in found["configurations"]]
    poses = ask(client, scene, "fk", configurations=configurations, frames=["arm::tcp", "above"])
    for pose in poses.json()["results"]:
        np.testing.assert_allclose(
            pose["arm::tcp"]["position"], pose["above"]["position"], atol=1e-4
        )
    verdicts = ask(client, scene, "check", configurations=configurations).json()["results"]
    assert all(verdict["valid"] for verdict in verdicts)


def test_unreachable_poses_come_with_the_nearest_and_the_funnel(client, scene):
    goal = {"type": "pose", "poses": [{"position": [9, 0, 0]}]}
    answer = ask(client, scene, "ik", goal=goal, ik={"max_trials": 20})
    assert answer.status_code == 200
    found = answer.json()
    assert found["configurations"] == []
    assert found["failure"]["code"] == "goal_unreachable"
    assert found["failure"]["evidence"]["nearest"]["translation_error"] > 7
    assert found["funnel"]["tried"] == 20


def test_the_same_seed_gives_the_same_configurations(client, scene):
    goal = {"type": "pose", "poses": [{"position": [0.4, 0.3, 0.3], "rpy": [3.1, 0, 0]}]}
    first, second = (ask(client, scene, "ik", goal=goal, seed=5).content for _ in range(2))
    assert first == second


def test_an_alias_means_the_same_group(client, scene):
    body = {"configurations": [[0.1] * 6], "group": "arm::arm"}
    alias = client.post(f"/v1/scenes/{scene}/fk", json=body).json()
    assert alias == ask(client, scene, "fk", configurations=[[0.1] * 6]).json()


def test_a_line_says_how_far_it_goes_and_what_stops_it(client, scene):
    way = {"vector": [0, 0, 0.1], "frame": "arm::tcp"}
    found = ask(client, scene, "line", displacement=way, poses=True).json()
    assert found["fraction"] == 1
    assert found["stopped_by"] is None
    assert found["length"] == pytest.approx(0.1)
    assert 0 < found["deviation"]["position"] <= 0.001
    poses = ask(client, scene, "fk", configurations=found["positions"]).json()["results"]
    for pose, wanted in zip(poses, found["poses"], strict=True):
        np.testing.assert_allclose(pose["arm::tcp"]["position"], wanted["position"], atol=1e-6)
    far = ask(client, scene, "line", displacement={"vector": [0, 0, 3]}).json()
    assert far["fraction"] < 1
    assert far["stopped_by"]["reason"] == "singularity"
    assert far["stopped_by"]["fraction"] == far["fraction"]
    into = {"position": [0, 0, 0], "rpy": [np.pi, 0, 0], "frame": "block"}
    hit = ask(client, scene, "line", pose=into).json()["stopped_by"]
    assert hit["reason"] == "collision"
    assert "block" in hit["pair"]["bodies"]


@pytest.mark.parametrize(
    ("body", "status", "word"),
    [
        ({}, 422, "displacement"),
        ({"displacement": {"vector": [0, 0, 1], "frame": "abve"}}, 409, "above"),
        ({"displacement": {"vector": [0, 0, 1]}, "frame": "arm::tpc"}, 409, "arm::tcp"),
        ({"displacement": {"vector": [0, 0, 1]}, "start": [0.0]}, 409, "6 positions"),
        ({"displacement": {"vector": [0, 0, 1]}, "max_step": 0}, 422, "max_step"),
    ],
)
def test_a_bad_line_names_what_is_wrong(client, scene, body, status, word):
    answer = ask(client, scene, "line", **body)
    assert answer.status_code == status
    assert word in answer.json()["detail"]
