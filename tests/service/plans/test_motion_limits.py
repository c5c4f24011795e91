"""Limits of frames, zones and signed accelerations over HTTP."""

import pytest

LIMITS = {
    "tool_limits": [{"frame": "arm::tcp", "speed": 0.2, "acceleration": 1.0}],
    "speed_zones": [
        {
            "name": "above",
            "frame": "arm::tcp",
            "box": {"size": [1, 1, 1], "pose": {"position": [0, 0, 0], "frame": "above"}},
            "speed": 0.1,
        }
    ],
    "acceleration_bounds": {"arm::elbow_joint": [-0.5, 1.5]},
}
CHECKS = ["tool_speed arm::tcp", "tool_acceleration arm::tcp", "speed_zone above"]


def ask(client, scene, retime):
    body = {
        "scene": scene,
        "group": "arm",
        "goal": {"type": "configuration", "name": "ready"},
        "retime": retime,
        "search": {"allowed_planning_time": 60.0},
    }
    return client.post("/v1/plans?wait=60", json=body)


def named(certificate):
    return {check["name"]: check for check in certificate["checks"]}


def test_a_plan_has_a_check_for_each(client, scene):
    job = ask(client, scene, {**LIMITS, "explain": True}).json()
    assert job["state"] == "succeeded", job["failure"]
    checks = named(job["result"]["certificate"])
    assert all(checks[name]["passed"] for name in CHECKS)
    assert checks["tool_speed arm::tcp"]["value"] <= checks["tool_speed arm::tcp"]["bound"] == 0.2
    drawing = client.get(f"/v1/plans/{job['id']}/plots/utilisation.svg").text
    assert all(f">{name}</text>" in drawing for name in [*CHECKS, "torque", "acceleration"])
    retime = job["result"]["stages"]["retime"]
    assert retime["binding"]["tool_speed"] == "arm::tcp"
    assert {"speed_zone", "tool_speed", "acceleration_bounds"} & {
        interval["limit"] for interval in retime["explanation"]["intervals"]
    }


def test_own_paths_are_timed_and_own_trajectories_held_against_them(client, scene):
    body = {
        "scene": scene,
        "group": "arm",
        "waypoints": [[0, -1.57, 1.57, -1.57, -1.57, 0], [0.5, -1.4, 1.4, -1.57, -1.57, 0]],
        "retime": LIMITS,
        "polynomial": True,
        "allowed_time": 60,
    }
    made = client.post("/v1/trajectories/retime", json=body).json()
    assert made["certificate"]["proven"], made["failure"]
    assert all(named(made["certificate"])[name]["passed"] for name in CHECKS)
    question = {"scene": scene, "group": "arm", "trajectory": made["trajectory"]}
    question["allowed_time"] = 60
    again = client.post("/v1/trajectories/certify", json={**question, **LIMITS}).json()
    assert again["certificate"]["proven"], again["certificate"]["checks"]
    tighter = {"tool_limits": [{"frame": "arm::tcp", "speed": 0.05}]}
    refused = client.post("/v1/trajectories/certify", json={**question, **tighter}).json()
    assert not refused["certificate"]["proven"]
    assert not named(refused["certificate"])["tool_speed arm::tcp"]["passed"]


@pytest.mark.parametrize(
    ("limits", "status", "words"),
    [
        ({"tool_limits": [{"frame": "arm::tpc", "speed": 1}]}, 422, "arm::tcp"),
        ({"tool_limits": [{"frame": "arm::tcp"}]}, 422, "speed"),
        ({"tool_limits": [{"frame": "arm::tcp", "speed": 0}]}, 422, "speed"),
        ({"tool_limits": LIMITS["tool_limits"] * 2}, 422, "twice"),
        ({"speed_zones": LIMITS["speed_zones"] * 2}, 422, "twice"),
        ({"speed_zones": [{**LIMITS["speed_zones"][0], "frame": "hand"}]}, 422, "hand"),
        ({"acceleration_bounds": {"arm::elbow": [-1, 1]}}, 422, "arm::elbow_joint"),
        ({"acceleration_bounds": {"arm::elbow_joint": [0, 1]}}, 422, "below 0"),
    ],
)
def test_what_cannot_be_meant_is_refused_everywhere(client, scene, limits, status, words):
    both = [0] * 6
    path = {"scene": scene, "group": "arm"}
    answers = [
        ask(client, scene, limits),
        client.post(
            "/v1/trajectories/retime", json={**path, "waypoints": [both, both], "retime": limits}
        ),
        client.post(
            "/v1/trajectories/certify",
            json={
                **path,
                "trajectory": {"times": [0, 1], "positions": [both, both]},
                **limits,
            },
        ),
    ]
    for answer in answers:
        assert answer.status_code == status, answer.text
        assert words in answer.text


@pytest.mark.parametrize("frame", ["world", "block", "above", "arm::base_link"])
def test_a_frame_that_does_not_move_keeps_every_limit(client, scene, frame):
    box = {"size": [0.1, 0.1, 0.1], "pose": {"position": [0, 0, 0], "frame": frame}}
    zone = {"name": "around", "frame": frame, "box": box, "speed": 0.1}
    limits = {
        "tool_limits": [{"frame": frame, "speed": 0.2, "acceleration": 1.0}],
        "speed_zones": [zone],
    }
    path = {"scene": scene, "group": "arm", "allowed_time": 60}
    body = {
        **path,
        "waypoints": [[0, -1.57, 1.57, -1.57, -1.57, 0], [0.5, -1.4, 1.4, -1.57, -1.57, 0]],
        "polynomial": True,
    }
    free, made = (
        client.post("/v1/trajectories/retime", json={**body, "retime": retime}).json()
        for retime in ({}, limits)
    )
    assert made["trajectory"]["duration"] == pytest.approx(free["trajectory"]["duration"], rel=5e-3)
    question = {**path, "trajectory": made["trajectory"], **limits}
    again = client.post("/v1/trajectories/certify", json=question).json()
    for certificate in (made["certificate"], again["certificate"]):
        checks = named(certificate)
        values = [
            checks[f"{kind} {frame}"]["value"] for kind in ("tool_speed", "tool_acceleration")
        ]
        assert values == [0, 0], certificate
        assert certificate["proven"]


def test_a_planar_joint_is_told_what_of_it_can_be_bounded(client):
    scene = {"robots": [{"name": "body", "model": "planar_l"}]}
    body = {
        "scene": client.post("/v1/scenes", json=scene).json()["id"],
        "group": "body",
        "goal": {"type": "joint", "positions": [0.1, 0, 0]},
        "retime": {"acceleration_bounds": {"body::base_joint.x": [-1, 1]}},
    }
    answer = client.post("/v1/plans", json=body)
    assert answer.status_code == 422
    assert answer.json()["evidence"]["known"] == ["body::base_joint.angular"]
    assert "body::base_joint.linear" in answer.json()["detail"]
