"""PATCH /v1/scenes/{id}: the next revision."""

from concurrent.futures import ThreadPoolExecutor

import pytest

import planning

PICKUP = (planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml").read_bytes()
YAML = {"content-type": "application/yaml"}
GRASP = {"position": [0, 0, 0.01], "rpy": [3.141592653589793, 0, 0]}


@pytest.fixture
def pickup(client):
    """A posted scene of its own."""
    return client.post("/v1/scenes", content=PICKUP, headers=YAML).json()


@pytest.fixture(scope="module")
def kept(client):
    """A posted scene that no test changes."""
    return client.post("/v1/scenes", content=PICKUP, headers=YAML).json()


def edit(client, scene, *operations, **more):
    return client.patch(f"/v1/scenes/{scene}", json={"operations": operations, **more})


def thing(document, name):
    return next(entry for entry in document["objects"] if entry["name"] == name)


def test_every_operation_is_done_and_the_rest_stays_as_it_was_posted(client, pickup):
    ball = {"name": "ball", "shape": {"sphere": 0.03}, "pose": {"position": [0.2, -0.5, 0.4]}}
    answer = edit(
        client,
        pickup["id"],
        {"op": "add", "object": ball},
        {"op": "move", "object": "box", "pose": {"position": [0.5, 0.1, 0.1305]}},
        {"op": "set_positions", "robot": "arm", "positions": {"left_finger_joint": 0.02}},
        {"op": "attach", "object": "can", "frame": "arm::tcp", "touch": ["arm::left_finger"]},
        {"op": "allow", "pair": ["ball", "box"]},
        {"op": "forbid", "pair": ["table", "arm::base_link"]},
    )
    assert answer.status_code == 200, answer.text
    edited = answer.json()
    assert edited["id"] == pickup["id"]
    assert edited["revision"] == 2
    document = edited["document"]
    assert thing(document, "can")["attached"] == {
        "frame": "arm::tcp",
        "touch": ["arm::left_finger"],
    }
    assert thing(document, "box")["pose"]["position"] == [0.5, 0.1, 0.1305]
    assert thing(document, "table") == thing(pickup["document"], "table")
    assert document["frames"] == pickup["document"]["frames"]
    assert document["allowed_collisions"] == [["ball", "box"]]
    gripper = next(group for group in edited["groups"] if group["name"] == "arm::gripper")
    assert gripper["positions"] == [0.02]
    undone = edit(
        client,
        pickup["id"],
        {"op": "detach", "object": "can"},
        {"op": "remove", "object": "ball"},
    ).json()
    assert undone["revision"] == 3
    assert undone["document"]["allowed_collisions"] == []
    assert thing(undone["document"], "can")["pose"]["position"] == pytest.approx([0.5, 0.3, 0.0605])


def test_old_revisions_stay_readable_and_plannable(client, pickup):
    path = f"/v1/scenes/{pickup['id']}"
    stowed = {"op": "set_positions", "robot": "arm", "positions": "stowed"}
    edited = edit(client, pickup["id"], stowed).json()
    assert edited.pop("executions") == []
    assert client.get(path).json() == edited
    assert client.get(f"{path}?revision=1").json() == pickup
    assert client.get(f"{path}?revision=3").status_code == 404
    listed = [
        item for item in client.get("/v1/scenes").json()["items"] if item["id"] == edited["id"]
    ]
    assert [item["revision"] for item in listed] == [2]
    request = {
        "scene": edited["id"],
        "group": "arm",
        "goal": {"type": "configuration", "name": "ready"},
        "search": {"allowed_planning_time": 60.0},
    }
    for revision, record in ((1, pickup), (2, edited), (None, edited)):
        job = client.post("/v1/plans?wait=60", json={**request, "revision": revision}).json()
        assert job["state"] == "succeeded", job["failure"]
        assert job["result"]["start"] == record["groups"][0]["positions"]


def test_a_held_thing_is_planned_with_over_http(client, pickup):
    held = {"op": "attach", "object": "can", "frame": "arm::tcp", "keep": False, "pose": GRASP}
    scene = edit(client, pickup["id"], held).json()
    goal = {"type": "pose", "poses": [{"position": [0.5, -0.28, 0.07]}], "frame": "can"}
    request = {"scene": scene["id"], "group": "arm", "goal": goal, "seed": 3}
    request["search"] = {"allowed_planning_time": 60.0}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    assert job["result"]["certificate"]["proven"]
    where = {"group": "arm", "configurations": [job["result"]["goal_configuration"]]}
    found = client.post(f"/v1/scenes/{scene['id']}/fk", json={**where, "frames": ["can"]}).json()
    assert found["results"][0]["can"]["position"] == pytest.approx([0.5, -0.28, 0.07], abs=1e-4)
    verdict = client.post(f"/v1/scenes/{scene['id']}/check", json=where).json()["results"][0]
    assert verdict["valid"]


IMPOSSIBLE = [
    ({"op": "move", "object": "cann", "pose": {}}, "unknown_name"),
    ({"op": "attach", "object": "can", "frame": "arm::tpc"}, "unknown_name"),
    ({"op": "set_positions", "robot": "arn", "positions": "home"}, "unknown_name"),
    ({"op": "allow", "pair": ["can", "tabel"]}, "unknown_name"),
    ({"op": "detach", "object": "can"}, "scene_edit_impossible"),
    ({"op": "attach", "object": "table", "frame": "arm::tcp"}, "scene_edit_impossible"),
    ({"op": "add", "object": {"name": "can", "shape": {"sphere": 1}}}, "scene_edit_impossible"),
    ({"op": "set_positions", "robot": "arm", "positions": [0]}, "scene_edit_impossible"),
]


@pytest.mark.parametrize(("operation", "code"), IMPOSSIBLE)
def test_what_is_impossible_here_is_refused_and_changes_nothing(client, kept, operation, code):
    answer = edit(client, kept["id"], {"op": "allow", "pair": ["can", "box"]}, operation)
    problem = answer.json()
    assert problem["code"] == code
    assert answer.status_code == (422 if code == "unknown_name" else 409)
    assert problem["evidence"]["operation"] == 1
    assert client.get(f"/v1/scenes/{kept['id']}").json() == kept


MALFORMED = [
    {"op": "explode", "object": "can"},
    {"op": "move", "object": "can"},
    {"op": "move", "object": "can", "pose": {}, "frame": "world"},
    {"op": "attach", "object": "can", "frame": "arm::tcp", "keep": False},
    {"op": "attach", "object": "can", "frame": "arm::tcp", "pose": {}},
    {"op": "allow", "pair": ["can"]},
    {"op": "add", "object": {"name": "x", "shape": {"sphere": -1}}},
    {"op": "set_positions", "robot": "arm", "positions": ["home"]},
]


@pytest.mark.parametrize("operation", MALFORMED)
def test_what_cannot_be_meant_is_refused(client, kept, operation):
    assert edit(client, kept["id"], operation).status_code == 422
    assert client.get(f"/v1/scenes/{kept['id']}").json() == kept


def test_no_edits_and_edits_of_nothing_are_refused(client, kept):
    assert edit(client, kept["id"]).status_code == 422
    assert edit(client, "scn_nothing", {"op": "remove", "object": "can"}).status_code == 404


def test_a_revision_that_is_not_the_latest_is_a_conflict(client, pickup):
    allow = {"op": "allow", "pair": ["can", "box"]}
    assert edit(client, pickup["id"], allow, revision=1).json()["revision"] == 2
    refusal = edit(client, pickup["id"], allow, revision=1)
    assert refusal.status_code == 409
    assert refusal.json()["code"] == "revision_conflict"
    assert refusal.json()["evidence"] == {"revision": 1, "latest": 2}
    assert edit(client, pickup["id"], allow, revision=7).status_code == 404


def test_edits_at_once_do_not_lose_each_other(client, pickup):
    def add(i):
        ball = {"name": f"ball_{i}", "shape": {"sphere": 0.01}}
        return edit(client, pickup["id"], {"op": "add", "object": ball}).status_code

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(add, range(4))) == [200] * 4
    latest = client.get(f"/v1/scenes/{pickup['id']}").json()
    assert latest["revision"] == 5
    assert {f"ball_{i}" for i in range(4)} <= set(latest["bodies"])
