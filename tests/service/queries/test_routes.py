"""Questions to a scene over HTTP."""

import numpy as np
import pytest

HOME = "home"


@pytest.fixture(scope="module")
def group(client, scene):
    return client.get(f"/v1/scenes/{scene}").json()["groups"][0]


def ask(client, scene, what, **body):
    patient = {"allowed_time": 60} if what in {"ik", "line"} else {}
    return client.post(f"/v1/scenes/{scene}/{what}", json={"group": "arm", **patient, **body})


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


def test_a_margin_makes_near_pairs_collide_but_none_within_the_robot(client, scene, group):
    home = group["configurations"]["home"]

    def verdict(margin):
        answer = ask(client, scene, "check", configurations=[home], margin=margin).json()
        return answer["results"][0]

    wide = verdict(0.5)
    distances = [pair["distance"] for pair in wide["collisions"]]
    assert distances == sorted(distances)
    assert 0 < distances[0] < distances[-1] < 0.5
    assert wide["distance"] < distances[0]
    assert all({"block", "post"} & set(pair["bodies"]) for pair in wide["collisions"])
    tight, loose = verdict(distances[0] + 1e-6), verdict(distances[0] - 1e-6)
    assert (tight["valid"], tight["collisions"]) == (False, wide["collisions"][:1])
    assert (loose["valid"], loose["collisions"]) == (True, [])


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


def answered(told):
    """What is answered, without what says how it came about."""
    answer = told.json()
    told_apart = {"revision", "digest", "timings", "versions", "statistics"}
    return {name: part for name, part in answer.items() if name not in told_apart}


def test_a_question_is_asked_of_the_revision_that_it_names(client):
    arm = {"name": "arm", "model": "ur5e", "positions": "home"}
    block = {
        "name": "block",
        "shape": {"box": [0.1, 0.1, 0.1]},
        "pose": {"position": [0.5, 0, 0.5]},
    }
    scene = client.post("/v1/scenes", json={"robots": [arm], "objects": [block]}).json()
    turned = {"position": [5, 0, 0], "rpy": [0, 0, 1.0]}
    away = {"op": "move", "object": "block", "pose": turned}
    path = f"/v1/scenes/{scene['id']}"
    client.patch(path, json={"operations": [away]})
    q = scene["groups"][0]["positions"]
    asked = {
        "fk": {"configurations": [q], "frames": ["block"]},
        "check": {"configurations": [q]},
        "ik": {
            "goal": {
                "type": "relative",
                "displacement": {"position": [0.02, 0, 0]},
                "reference": "block",
            }
        },
        "line": {"displacement": {"vector": [0.02, 0, 0], "frame": "block"}},
    }
    for verb, body in asked.items():
        told = [
            client.post(f"{path}/{verb}{query}", json={"group": "arm", **body})
            for query in ("?revision=1", "?revision=2", "", "?revision=3")
        ]
        assert [one.status_code for one in told] == [200, 200, 200, 404], verb
        assert told[1].json() == told[2].json()
        assert [one.headers.get("wayproof-revision") for one in told] == ["1", "2", "2", None]
        assert answered(told[0]) != answered(told[1]), verb
    [first] = client.post(f"{path}/fk?revision=1", json={"group": "arm", **asked["fk"]}).json()[
        "results"
    ]
    assert first["block"]["position"] == [0.5, 0.0, 0.5]


def test_the_same_seed_gives_the_same_configurations(client, scene):
    goal = {"type": "pose", "poses": [{"position": [0.4, 0.3, 0.3], "rpy": [3.1, 0, 0]}]}
    first, second = (ask(client, scene, "ik", goal=goal, seed=5).content for _ in range(2))
    assert first == second


def test_an_alias_means_the_same_group(client, scene):
    body = {"configurations": [[0.1] * 6], "group": "arm::arm"}
    alias = client.post(f"/v1/scenes/{scene}/fk", json=body).json()
    assert alias == ask(client, scene, "fk", configurations=[[0.1] * 6]).json()


DOWN = {"position": [0.4, 0.3, 0.3], "rpy": [np.pi, 0, 0]}


def test_ik_solutions_say_how_good_they_are_and_are_sorted_by_the_weights(client, scene):
    goal = {"type": "pose", "poses": [DOWN]}
    weights = {"arm::elbow_joint": 5.0, "arm::shoulder_pan_joint": 0.0}
    found = ask(client, scene, "ik", goal=goal, ik={"joint_weights": weights}).json()
    solutions = found["configurations"]
    distances = [solution["distance"] for solution in solutions]
    assert distances == sorted(distances)
    verdicts = ask(
        client, scene, "check", configurations=[one["positions"] for one in solutions]
    ).json()["results"]
    for solution, verdict in zip(solutions, verdicts, strict=True):
        assert solution["clearance"] == pytest.approx(verdict["distance"], abs=1e-9)
        assert solution["pair"] == verdict["nearest"]["bodies"]
        assert 0 <= solution["limit_margin"] <= 0.5
        assert solution["manipulability"] > 0
        assert set(solution["branch"]) == {"shoulder", "elbow", "wrist"}


def test_the_funnel_of_ik_gives_every_rejection_its_reason(client, scene):
    goal = {"type": "pose", "poses": [{"position": [0.6, 0, 0.09], "rpy": [np.pi, 0, 0]}]}
    funnel = ask(client, scene, "ik", goal=goal, ik={"max_trials": 100}).json()["funnel"]
    counts = [entry["count"] for entry in funnel["rejected"]]
    assert sum(counts) + funnel["distinct"] == funnel["tried"]
    hits = [entry for entry in funnel["rejected"] if entry["reason"] == "collision"]
    assert hits
    for hit in hits:
        assert len(hit["bodies"]) == 2
        assert 0 < hit["min_depth"] <= hit["max_depth"]
    assert funnel["summary"].startswith(f"{funnel['tried']} tried, {funnel['converged']} converged")


ASIDE = {"position": [0.4, -0.3, 0.3], "rpy": [np.pi, 0, 0]}


@pytest.mark.parametrize("targets", [{"pose": DOWN}, {"poses": [DOWN, ASIDE]}])
def test_ik_of_a_region(client, scene, targets):
    goal = {
        "type": "region",
        **targets,
        "tolerance": {"position": [0.05, 0.02, 0]},
        "free_axes": ["rz"],
    }
    found = ask(client, scene, "ik", goal=goal, ik={"max_configurations": 20}).json()
    rows = [entry["positions"] for entry in found["configurations"]]
    assert len(rows) == 20
    poses = ask(client, scene, "fk", configurations=rows, frames=["arm::tcp"]).json()["results"]
    places = np.array([pose["arm::tcp"]["position"] for pose in poses])
    centers = np.array([one["position"] for one in targets.get("poses", [DOWN])])
    away = np.abs(places[:, None] - centers)
    is_inside = (away <= np.array([0.05, 0.02, 0]) + 1e-5).all(axis=2)
    assert is_inside.any(axis=1).all()
    assert is_inside.any(axis=0).all()  # every target is tried


def test_ik_of_poses_by_a_metric(client, scene):
    metric = {"tolerance": 0.03, "weights": [1, 1, 0, 0.1], "frame": "world"}
    goal = {"type": "pose", "poses": [DOWN], "metric": metric}
    found = ask(client, scene, "ik", goal=goal, ik={"max_configurations": 20}).json()
    rows = [entry["positions"] for entry in found["configurations"]]
    poses = ask(client, scene, "fk", configurations=rows, frames=["arm::tcp"]).json()["results"]
    ways = np.array([pose["arm::tcp"]["position"] for pose in poses]) - DOWN["position"]
    assert (np.hypot(ways[:, 0], ways[:, 1]) <= 0.03 + 1e-5).all()
    assert np.abs(ways[:, 2]).max() > 0.05


def test_ik_says_what_it_had_tried_when_time_was_over(client, scene):
    """However many trials are asked for: the time is kept, and the funnel is told."""
    goal = {
        "type": "region",
        "pose": {"position": [0.6, 0, 0.05], "rpy": [np.pi, 0, 0]},
        "free_axes": ["rz"],
    }
    ik = {"max_trials": 100_000, "allowed_time": 0.05}
    found = ask(client, scene, "ik", goal=goal, ik=ik).json()
    assert found["configurations"] == []
    assert found["failure"]["code"] == "deadline_exceeded"
    assert found["failure"]["evidence"]["cut_short"]
    assert found["funnel"]["tried"] < 100_000


def test_ik_of_a_displacement(client, scene, group):
    goal = {"type": "relative", "displacement": {"position": [0, 0, 0.03]}, "reference": "world"}
    found = ask(client, scene, "ik", goal=goal).json()
    rows = [group["positions"], found["configurations"][0]["positions"]]
    before, after = ask(client, scene, "fk", configurations=rows).json()["results"]
    moved = np.subtract(after["arm::tcp"]["position"], before["arm::tcp"]["position"])
    np.testing.assert_allclose(moved, [0, 0, 0.03], atol=1e-5)
    np.testing.assert_allclose(
        after["arm::tcp"]["quaternion"], before["arm::tcp"]["quaternion"], atol=1e-5
    )


def test_a_colliding_goal_comes_with_what_is_nearest_and_what_would_do(client, scene):
    goal = {"type": "pose", "poses": [{"position": [0.6, 0, 0.05], "rpy": [np.pi, 0, 0]}]}
    found = ask(client, scene, "ik", goal=goal, ik={"max_trials": 60}).json()
    assert found["failure"]["code"] == "goal_in_collision"
    evidence = found["failure"]["evidence"]
    nearest, relaxation = evidence["nearest"], evidence["relaxation"]
    assert nearest["binding"] == "collision"
    assert 0.0 < nearest["translation_error"] < 0.2
    assert {body for one in relaxation["obstacles"] for body in one["bodies"]} >= {"block"}
    assert max(relaxation["tolerance"]["position"]) > 0
    verdict = ask(client, scene, "check", configurations=[nearest["positions"]]).json()
    assert verdict["results"][0]["valid"]


@pytest.mark.parametrize(
    ("body", "status", "word"),
    [
        ({"goal": {"type": "region", "pose": DOWN, "free_axes": ["yaw"]}}, 422, "rz"),
        ({"goal": {"type": "region"}}, 422, "pose"),
        ({"goal": {"type": "region", "pose": DOWN, "poses": [DOWN]}}, 422, "poses"),
        ({"goal": {"type": "region", "pose": {**DOWN, "frame": "abov"}}}, 422, "above"),
        ({"goal": {"type": "relative", "displacement": {}}}, 422, "position"),
        ({"goal": {"type": "relative", "displacement": {"quaternion": [0] * 4}}}, 422, "zero"),
        (
            {"goal": {"type": "relative", "displacement": DOWN, "reference": "blok"}},
            422,
            "block",
        ),
        ({"goal": {"type": "configuration", "name": "home"}}, 422, "relative"),
        (
            {"goal": {"type": "pose", "poses": [DOWN]}, "ik": {"joint_weights": {"elbow": 1}}},
            422,
            "arm::elbow_joint",
        ),
        (
            {"goal": {"type": "pose", "poses": [DOWN]}, "ik": {"pose_metric": {"rotation": 0}}},
            422,
            "pose_metric",
        ),
    ],
)
def test_questions_that_cannot_be_meant_are_told_what_can(client, scene, body, status, word):
    answer = ask(client, scene, "ik", **body)
    assert answer.status_code == status
    assert word in answer.json()["detail"]


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
        ({"displacement": {"vector": [0, 0, 1], "frame": "abve"}}, 422, "above"),
        ({"displacement": {"vector": [0, 0, 1]}, "frame": "arm::tpc"}, 422, "arm::tcp"),
        ({"displacement": {"vector": [0, 0, 1]}, "start": [0.0]}, 409, "6 positions"),
        ({"displacement": {"vector": [0, 0, 1]}, "max_step": 0}, 422, "max_step"),
    ],
)
def test_a_bad_line_names_what_is_wrong(client, scene, body, status, word):
    answer = ask(client, scene, "line", **body)
    assert answer.status_code == status
    assert word in answer.json()["detail"]


def test_ik_keeps_path_constraints(client, scene, group):
    home = group["configurations"]["home"]
    joint = group["joints"][0]["name"]
    pose = {"position": [0, 0, 0], "rpy": [np.pi, 0, 0], "frame": "above"}
    goal = {"type": "pose", "poses": [pose]}
    free = ask(client, scene, "ik", goal=goal).json()["configurations"]
    held = home[0] - 1.5, home[0] + 1.5
    assert not all(held[0] <= one["positions"][0] <= held[1] for one in free)
    limits = {"type": "joint_limits", "limits": {joint: held}}
    kept = ask(client, scene, "ik", goal=goal, path_constraints=[limits]).json()
    assert kept["configurations"]
    assert all(held[0] <= one["positions"][0] <= held[1] for one in kept["configurations"])
    box = {"size": [0.01, 0.01, 0.01], "pose": {"position": [9, 9, 9]}}
    inside = {"type": "keep_in", "frame": "arm::tool0", "box": box}
    refused = ask(client, scene, "ik", goal=goal, path_constraints=[inside]).json()
    assert refused["configurations"] == []
    assert refused["failure"]["code"] == "goal_violates_constraint"
    unknown = {"type": "locked_joints", "joints": ["elbow"]}
    problem = ask(client, scene, "ik", goal=goal, path_constraints=[unknown])
    assert problem.status_code == 422
    assert "arm::elbow_joint" in str(problem.json()["evidence"])
