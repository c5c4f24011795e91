"""Bad input: the right status, a stable code, and a message that helps."""

import json

import pytest

ARM = {"name": "arm", "model": "ur5e"}
HOME = {"type": "configuration", "name": "home"}


def with_object(shape):
    return {"robots": [ARM], "objects": [{"name": "thing", "shape": shape}]}


BAD_SCENES = {
    "unknown robot": ({"robots": [{"name": "a", "model": "ur6"}]}, 422, "unknown_name", "ur6"),
    "robot file that is not there": (
        {"robots": [{"name": "a", "model": "/nowhere/x.urdf"}]}, 422, "asset_not_found", "nowhere",
    ),
    "unknown field": ({"robots": [ARM], "object": []}, 422, "scene_invalid", "object"),
    "unknown version": ({"robots": [ARM], "version": 2}, 422, "scene_invalid", "version"),
    "no robots": ({"robots": []}, 422, "scene_invalid", "robots"),
    "zero box": (with_object({"box": [1, 0, 1]}), 422, "scene_invalid", "box"),
    "negative radius": (with_object({"sphere": -0.1}), 422, "scene_invalid", "sphere"),
    "zero cylinder": (
        with_object({"cylinder": {"radius": 0.1, "length": 0}}), 422, "scene_invalid", "length",
    ),
    "two shapes": (with_object({"sphere": 1, "box": [1, 1, 1]}), 422, "scene_invalid", "shape"),
    "unknown shape": (with_object({"ball": 1}), 422, "scene_invalid", "ball"),
    "unknown parent": (
        {"robots": [ARM], "frames": [{"name": "f", "parent": "x"}]}, 422, "scene_invalid",
        "frame 'x' does not exist",
    ),
    "wrong count": (
        {"robots": [{**ARM, "positions": [0, 0]}]}, 422, "scene_invalid", "6 positions",
    ),
    "same name twice": ({"robots": [ARM, ARM]}, 422, "scene_invalid", "arm"),
    "infinite size": (with_object({"sphere": float("inf")}), 422, "scene_invalid", "sphere"),
    "not a number": (with_object({"sphere": float("nan")}), 422, "scene_invalid", "sphere"),
    "number as text": (with_object({"sphere": "1"}), 422, "scene_invalid", "sphere"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_SCENES)
def test_bad_scenes(client, name):
    document, status, code, word = BAD_SCENES[name]
    headers = {"content-type": "application/json"}
    answer = client.post("/v1/scenes", content=json.dumps(document), headers=headers)
    problem = answer.json()
    assert answer.status_code == problem["status"] == status, problem
    assert answer.headers["content-type"] == "application/problem+json"
    assert problem["code"] == code
    assert word in problem["detail"]


def joint_goal(*positions):
    return {"goal": {"type": "joint", "positions": list(positions)}}


POSE = {"position": [0, 0, 0]}
CUP = {
    "type": "orientation", "frame": "arm::tcp", "axis": [0, 0, 1], "direction": [0, 0, -1],
    "tolerance": 0.1,
}  # fmt: skip
BAD_PLANS = {
    "unknown scene": ({"scene": "nothing"}, 404, "not_found", "nothing"),
    "unknown revision": ({"revision": 2}, 404, "not_found", "2"),
    "unknown group": ({"group": "leg"}, 422, "unknown_name", "leg"),
    "unknown frame of a pose": (
        {"goal": {"type": "pose", "poses": [{**POSE, "frame": "abov"}]}}, 422, "unknown_name",
        "did you mean 'above'",
    ),
    "unknown tool frame": (
        {"goal": {"type": "pose", "poses": [POSE], "frame": "arm::x"}}, 422, "unknown_name",
        "arm::x",
    ),
    "unknown configuration": (
        {"goal": {"type": "configuration", "name": "hom"}}, 422, "unknown_name", "'home'",
    ),
    "wrong count in the goal": (joint_goal(0, 0), 409, "wrong_joint_count", "6 positions, got 2"),
    "wrong count in the start": ({"start": [0] * 7}, 409, "wrong_joint_count", "got 7"),
    "unknown planner": (
        {"search": {"planner": "RRTConect"}}, 422, "unknown_name", "did you mean 'RRTConnect'",
    ),
    "unknown parameter": (
        {"search": {"parameters": {"rnge": 1}}}, 422, "unknown_name", "did you mean 'range'",
    ),
    "unknown field": ({"speed": 1}, 422, "request_invalid", "speed"),
    "unknown inner field": ({"retime": {"metod": "toppra"}}, 422, "request_invalid", "metod"),
    "not a number": (joint_goal(*[float("nan")] * 6), 422, "request_invalid", "finite"),
    "infinite": ({"start": [float("inf")] * 6}, 422, "request_invalid", "start"),
    "number as text": (joint_goal(*["0"] * 6), 422, "request_invalid", "goal"),
    "boolean as number": ({"seed": True}, 422, "request_invalid", "seed"),
    "scale above one": ({"retime": {"velocity_scale": 1.1}}, 422, "request_invalid", "velocity"),
    "no time": ({"search": {"allowed_planning_time": 0}}, 422, "request_invalid", "allowed"),
    "negative margin": ({"margin": -0.1}, 422, "request_invalid", "margin"),
    "zero quaternion": (
        {"goal": {"type": "pose", "poses": [{**POSE, "quaternion": [0, 0, 0, 0]}]}}, 422,
        "request_invalid", "quaternion",
    ),
    "two rotations": (
        {"goal": {"type": "pose", "poses": [{**POSE, "quaternion": [1, 0, 0, 0], "rpy": [0] * 3}]}},
        422, "request_invalid", "not both",
    ),
    "unknown goal type": ({"goal": {"type": "fly"}}, 422, "request_invalid", "goal"),
    "two tolerances": (
        {
            "goal": {
                "type": "pose", "poses": [POSE], "tolerance": {"position": [0.1] * 3},
                "metric": {"tolerance": 0.1},
            }
        },
        422, "request_invalid", "not both",
    ),
    "metric by no axes": (
        {"goal": {"type": "pose", "poses": [POSE], "metric": {"tolerance": 1, "frame": "abve"}}},
        422, "unknown_name", "above",
    ),
    "flat approach": (
        {"goal": {"type": "pose", "poses": [POSE], "approach": [0, -0.1]}}, 422,
        "request_invalid", "approach",
    ),
    "line into nowhere": (
        {"goal": {"type": "line", "pose": {**POSE, "frame": "abve"}}}, 422, "unknown_name", "above",
    ),
    "line to nowhere": ({"goal": {"type": "line"}}, 422, "request_invalid", "`displacement`"),
    "line along nothing": (
        {"goal": {"type": "line", "displacement": {"vector": [0, 0, 1], "frame": "abve"}}}, 422,
        "unknown_name", "above",
    ),
    "path of no poses": ({"goal": {"type": "path", "poses": []}}, 422, "request_invalid", "poses"),
    "unknown constraint": (
        {"path_constraints": [{"type": "upright"}]}, 422, "request_invalid", "path_constraints",
    ),
    "empty band": (
        {"path_constraints": [{"type": "distance_band", "min": 0.1, "max": 0.05}]}, 422,
        "request_invalid", "`min` must be less than `max`",
    ),
    "no axis": (
        {"path_constraints": [{**CUP, "axis": [0, 0, 0]}]}, 422, "request_invalid", "must not be",
    ),
    "constraint on no frame": (
        {"path_constraints": [{**CUP, "frame": "arm::tcq"}]}, 422, "unknown_name", "arm::tcp",
    ),
    "constraint on no body": (
        {"path_constraints": [{"type": "distance_band", "min": 0.1, "to": ["blok"]}]}, 422,
        "unknown_name", "did you mean 'block'",
    ),
    "lock of no joint": (
        {"path_constraints": [{"type": "locked_joints", "joints": ["elbow_joint"]}]}, 422,
        "unknown_name", "arm::elbow_joint",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_PLANS)
def test_bad_plans(client, scene, name):
    change, status, code, word = BAD_PLANS[name]
    request = {"scene": scene, "group": "arm", "goal": HOME, **change}
    headers = {"content-type": "application/json"}
    answer = client.post("/v1/plans", content=json.dumps(request), headers=headers)
    problem = answer.json()
    assert answer.status_code == problem["status"] == status, problem
    assert problem["code"] == code
    assert word in problem["detail"]
    members = {"type", "title", "status", "code", "detail", "evidence"}
    assert set(problem) - {"errors"} == members


BAD_BODIES = {
    "nothing": ("application/json", b"", 422),
    "broken JSON": ("application/json", b'{"scene":', 400),
    "not UTF-8": ("application/json", b'{"scene": "\xff"}', 400),
    "a list": ("application/json", b"[]", 422),
    "deep": ("application/json", b"[" * 1_000_000, 400),
    "another type": ("text/plain", b"{}", 415),
    "no type": ("", b"{}", 415),
}


@pytest.mark.parametrize("name", BAD_BODIES)
def test_bad_bodies(client, name):
    media, body, status = BAD_BODIES[name]
    answer = client.post("/v1/plans", content=body, headers={"content-type": media})
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"


# What takes work in proportion to its length is over in a second; its square is not in an hour, and
# the suite's time limit ends it.
def refused(client, path, body, media):
    answer = client.post(path, content=body, headers={"content-type": media})
    assert 400 <= answer.status_code < 500
    assert len(answer.content) < 20_000
    return answer.json()["code"]


def test_megabytes_of_nonsense_are_refused(client):
    text = b"nonsense: [1, 2, 3]\n" * 500_000
    assert refused(client, "/v1/scenes", text, "application/yaml") == "body_too_large"
    assert refused(client, "/v1/scenes", text, "application/json") == "unreadable_body"
    keys = json.dumps({f"a key of a scene of nonsense {i}": [i] for i in range(100_000)}).encode()
    assert refused(client, "/v1/scenes", keys, "application/json") == "scene_invalid"
    assert refused(client, "/v1/plans", keys, "application/json") == "body_too_large"


def test_bodies_beyond_the_bound_are_refused_whatever_they_announce(client, settings):
    body = b"x" * (settings.max_body_bytes + 1)
    assert refused(client, "/v1/scenes", body, "application/json") == "body_too_large"
    unannounced = iter([body[: len(body) // 2], body[len(body) // 2 :]])
    assert refused(client, "/v1/scenes", unannounced, "application/json") == "body_too_large"


def test_alias_bombs_are_refused(client):
    bomb = "a: &a [x, x, x]\n" + "".join(
        f"{chr(98 + i)}: &{chr(98 + i)} [{', '.join(['*' + chr(97 + i)] * 9)}]\n" for i in range(9)
    )
    assert refused(client, "/v1/scenes", bomb.encode(), "text/yaml") == "scene_invalid"


def test_a_fault_in_yaml_names_its_line(client):
    text = "robots:\n  - {name: arm, model: ur5e}\nobjects:\n  - {name: a, shape: {sphere: -1}}\n"
    answer = client.post("/v1/scenes", content=text, headers={"content-type": "application/yaml"})
    assert answer.json()["evidence"]["line"] == 4
    assert "line 4" in answer.json()["detail"]


@pytest.mark.parametrize("query", ["limit=0", "limit=x", "cursor=x", "state=unknown"])
def test_bad_parameters(client, query):
    answer = client.get(f"/v1/plans?{query}")
    assert answer.status_code == 422
    assert answer.json()["code"] == "request_invalid"


def test_parameters_that_nobody_declared_are_refused_everywhere(client, document):
    for path, verbs in document["paths"].items():
        for verb in set(verbs) & {"get", "post", "patch", "delete"}:
            answer = client.request(verb, path, params={"foo": "1"}, json={})
            problem = answer.json()
            assert (answer.status_code, problem["code"]) == (422, "unknown_name"), (verb, path)
            declared = verbs[verb].get("parameters", [])
            known = sorted(one["name"] for one in declared if one["in"] == "query")
            assert problem["evidence"]["known"] == known


def test_a_misspelt_parameter_is_told_the_right_one(client):
    answer = client.get("/v1/scenes?cursr=3")
    assert answer.status_code == 422
    assert "'cursr' does not exist; did you mean 'cursor'?" in answer.json()["detail"]
    waited = client.post("/v1/plans?wiat=3", json={})
    assert "did you mean 'wait'?" in waited.json()["detail"]


@pytest.mark.parametrize("path", ["/", "/healthz", "/readyz", "/metrics", "/docs", "/openapi.json"])
def test_probes_and_pages_are_no_exception(client, path):
    answer = client.get(path, params={"probe": "1"})
    assert (answer.status_code, answer.json()["code"]) == (422, "unknown_name")


@pytest.mark.parametrize("query", ["period=0", "period=nan", "scale=0", "scale=2", "format=xml"])
def test_bad_parameters_of_trajectories(client, solved, query):
    answer = client.get(f"/v1/plans/{solved['id']}/trajectory?{query}")
    assert answer.status_code == 422
