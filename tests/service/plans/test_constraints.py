"""Path constraints over HTTP: each has its check in the certificate, or the job says why not."""


def planned(client, scene, *constraints):
    request = {
        "scene": scene,
        "group": "arm",
        "goal": {"type": "configuration", "name": "ready"},
        "path_constraints": list(constraints),
        "search": {"allowed_planning_time": 60.0},
        "seed": 3,
    }
    answer = client.post("/v1/plans?wait=60", json=request)
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_every_constraint_has_its_check(client, scene):
    away = {"size": [0.1, 0.1, 0.1], "pose": {"position": [0, 0, 2], "frame": "above"}}
    job = planned(
        client,
        scene,
        {"type": "keep_out", "frame": "arm::tcp", "box": away},
        {"type": "keep_in", "frame": "arm::tcp", "box": {"size": [4, 4, 4]}},
        {"type": "position", "frame": "arm::tcp", "size": [None, None, 4]},
        {"type": "distance_band", "to": ["block"], "min": 0.001},
        {"type": "joint_limits", "limits": {"arm::elbow_joint": [-3.1, 3.1]}},
    )
    assert job["state"] == "succeeded", job["failure"]
    checks = {check["name"]: check for check in job["result"]["certificate"]["checks"]}
    kinds = ["keep_out", "keep_in", "position", "distance_band", "joint_limits"]
    for i, kind in enumerate(kinds):
        assert checks[f"constraint {i}: {kind}"]["passed"]


def test_a_start_that_violates_is_a_failed_job(client, scene):
    up = {"type": "orientation", "frame": "arm::tcp", "axis": [0, 0, 1], "tolerance": 0.1}
    job = planned(client, scene, {**up, "direction": [0, 0, 1]})
    assert job["state"] == "failed"
    failure = job["failure"]
    assert failure["code"] == "start_violates_constraint"
    assert failure["stage"] == "goals"
    (violation,) = failure["evidence"]["violations"]
    assert violation["constraint"] == "constraint 0: orientation"
    assert violation["value"] > violation["bound"] == 0.1


def test_a_violated_constraint_on_joints_says_which(client, scene):
    wrist, elbow = "arm::wrist_2_joint", "arm::elbow_joint"
    limits = {wrist: [-3, 3], elbow: [0, 0.1]}
    failure = planned(client, scene, {"type": "joint_limits", "limits": limits})["failure"]
    assert failure["code"] == "start_violates_constraint"
    (violation,) = failure["evidence"]["violations"]
    assert violation["joint"] == elbow
    assert "constraint 0 (joint_limits) by " in failure["detail"]
    assert f"at {elbow} (" in failure["detail"]
    failure = planned(client, scene, {"type": "locked_joints", "joints": [wrist, elbow]})["failure"]
    assert failure["code"] == "goal_violates_constraint"
    (tally,) = failure["evidence"]["violations"]
    assert tally["least"]["joint"] in limits
    assert tally["least"]["joint"] in failure["detail"]
