"""Cars over HTTP: what they can drive is told, asked for, and refused where they cannot."""

import pytest

SCENE = {
    "robots": [
        {"name": "car", "model": "car", "positions": [-0.9, 0.0, 0.0]},
        {"name": "body", "model": "planar_l", "base": {"position": [2.5, 2.5, 0]}},
    ],
    "objects": [
        {"name": "post", "shape": {"sphere": 0.1}, "pose": {"position": [0.0, 0.0, 0.1]}},
    ],
}
JOINT = "car::base_joint"


@pytest.fixture(scope="module")
def scene(client):
    return client.post("/v1/scenes", json=SCENE).json()["id"]


@pytest.fixture
def plan(client, scene):
    def ask(search, group="car", positions=(0.6, 0.1, 0.0)):
        request = {
            "scene": scene,
            "group": group,
            "goal": {"type": "joint", "positions": [list(positions)]},
            "search": {"allowed_planning_time": 60.0, **search},
        }
        return client.post("/v1/plans?wait=60", json=request)

    return ask


def test_a_plan_of_a_car_is_proven(plan):
    job = plan({"spaces": {JOINT: {"turning_radius": 0.4, "reverse": False}}}).json()
    assert job["state"] == "succeeded", job["failure"]
    checks = {check["name"]: check for check in job["result"]["certificate"]["checks"]}
    assert checks[f"steering {JOINT}"]["passed"]
    assert job["result"]["stages"]["refine"]["improved"]
    assert job["request"]["search"]["spaces"] == {JOINT: {"turning_radius": 0.4, "reverse": False}}


def test_models_tell_how_they_are_steered(client):
    groups = client.get("/v1/models/car").json()["groups"]
    assert groups[0]["joints"][0]["steering"] == {"turning_radius": 0.3, "reverse": True}
    groups = client.get("/v1/models/planar_l").json()["groups"]
    assert groups[0]["joints"][0]["steering"] is None


@pytest.mark.parametrize(
    ("search", "code", "names"),
    [
        ({"spaces": {"car::base": {"turning_radius": 0.4}}}, "unknown_name", [JOINT]),
        ({"spaces": {JOINT: {"turning_radius": 0.1}}}, "problem_invalid", ["0.3"]),
        ({"planner": "GCS"}, "problem_invalid", [JOINT, "cannot follow"]),
        ({"spaces": {JOINT: {"turning_radius": 0}}}, "request_invalid", []),
        ({"spaces": {JOINT: {"radius": 0.4}}}, "request_invalid", []),
        ({"spaces": {JOINT: "car"}}, "request_invalid", []),
        (
            {
                "planner": ["RRT", "PRM"],
                "spaces": {JOINT: {"turning_radius": 0.4, "reverse": False}},
            },
            "problem_invalid",
            ["PRM", "RRTConnect", "KPIECE1"],
        ),
    ],
)
def test_what_cannot_be_driven_is_refused(plan, search, code, names):
    answer = plan(search)
    assert answer.status_code == 422
    assert answer.json()["code"] == code
    assert all(name in answer.json()["detail"] for name in names)


def test_a_body_that_is_to_drive_has_no_regions(plan):
    """What the request makes a car of is refused before anybody is sent to grow regions."""
    search = {"planner": "GCS", "spaces": {"body::base_joint": {"turning_radius": 0.4}}}
    answer = plan(search, group="body")
    assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
    assert "body::base_joint" in answer.json()["detail"]
    assert plan({"planner": "GCS"}, group="body").json()["code"] == "no_regions"


def test_no_regions_are_grown_for_cars(client, scene):
    answer = client.post(f"/v1/scenes/{scene}/regions", json={"group": "car"})
    assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
    assert answer.json()["evidence"] == {"field": "group", "joints": [JOINT]}


@pytest.mark.parametrize(
    ("space", "detail"),
    [
        ({"turning_radius": -1}, ".turning_radius: Input should be greater than or equal to 0.001"),
        (
            {"turning_radius": 1, "turning": 1},
            (
                ".turning: field 'turning' does not exist; did you mean 'turning_radius'? "
                "fields: ['reverse', 'turning_radius']"
            ),
        ),
        ({}, ".turning_radius: Field required"),
        ("car", ": Input should be 'full' or 'position'"),
    ],
)
def test_a_fault_of_a_space_is_told_of_what_was_meant(plan, space, detail):
    answer = plan({"spaces": {JOINT: space}})
    assert answer.status_code == 422
    assert answer.json()["detail"] == f"body.search.spaces.{JOINT}{detail}"


def test_any_planner_will_do_for_a_car_that_reverses(plan):
    job = plan({"planner": "KPIECE1", "spaces": {JOINT: {"turning_radius": 0.3}}}).json()
    assert job["state"] == "succeeded", job["failure"]


def test_a_request_makes_a_car_of_a_body(plan):
    search = {"spaces": {"body::base_joint": {"turning_radius": 0.1}}}
    job = plan(search, "body", (0.2, 0.3, 1.0)).json()
    assert job["state"] == "succeeded", job["failure"]
    names = [check["name"] for check in job["result"]["certificate"]["checks"]]
    assert "steering body::base_joint" in names


def test_a_motion_that_slips_is_refused_in_numbers(client, scene):
    still = [[0.0, 0.0, 0.0]] * 2
    for end, when in (([-0.9, 0.1, 0.0], 3.0), ([-0.9, 0.0, 3e4], 1.0)):
        motion = {"times": [0, when], "positions": [[-0.9, 0.0, 0.0], end], "velocities": still}
        request = {"scene": scene, "group": "car", "trajectory": motion}
        answer = client.post("/v1/trajectories/certify", json=request)
        assert answer.status_code == 200
        checks = {check["name"]: check for check in answer.json()["certificate"]["checks"]}
        assert not checks[f"steering {JOINT}"]["passed"]
