"""Scenes over HTTP."""

import pytest

from planning import bundled_folder
from tests.profiles import pairs
from tests.service.pages import walk

SCENES = sorted(bundled_folder("scenes").glob("*.scene.yaml"))
ARM = {"robots": [{"name": "arm", "model": "ur5e"}]}


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("path", "media"),
    pairs(SCENES, ["application/yaml", "text/yaml", "application/x-yaml"]),
    ids=lambda one: getattr(one, "name", one).split(".")[0],
)
def test_bundled_scenes_are_accepted_as_yaml(client, path, media):
    answer = client.post(
        "/v1/scenes", content=path.read_bytes(), headers={"content-type": f"{media}; charset=utf-8"}
    )
    assert answer.status_code == 201, answer.text
    scene = answer.json()
    assert answer.headers["location"] == f"/v1/scenes/{scene['id']}"
    assert scene["revision"] == 1
    assert scene["groups"]


def test_yaml_and_json_of_one_scene_have_one_digest(client):
    text = SCENES[0].read_bytes()
    posted = client.post(
        "/v1/scenes", content=text, headers={"content-type": "application/yaml"}
    ).json()
    again = client.post("/v1/scenes", json=posted["document"]).json()
    assert again["digest"] == posted["digest"]
    assert again["document"] == posted["document"]
    assert again["id"] != posted["id"]


def test_a_scene_is_shown_listed_and_forgotten(client):
    posted = client.post("/v1/scenes", json=ARM).json()
    path = f"/v1/scenes/{posted['id']}"
    assert client.get(path).json() == posted
    brief = client.get("/v1/scenes").json()["items"][0]
    assert brief == {key: posted[key] for key in brief}
    assert client.delete(path).status_code == 204
    for gone in (
        client.get(path),
        client.delete(path),
        client.post(f"{path}/check", json={"group": "arm", "configurations": [[0] * 6]}),
    ):
        assert gone.status_code == 404
        assert gone.json()["code"] == "not_found"


def test_pages_of_scenes_join_up(client):
    for _ in range(3):
        client.post("/v1/scenes", json=ARM)
    whole = walk(client, "/v1/scenes", limit=200)
    assert len({scene["id"] for scene in whole}) == len(whole) >= 3
    assert walk(client, "/v1/scenes", limit=3) == whole


def test_a_group_tells_everything_a_request_needs(client, scene):
    group = client.get(f"/v1/scenes/{scene}").json()["groups"][0]
    count = len(group["position_names"])
    assert group["name"] == "arm"
    assert "arm::arm" in group["aliases"]
    assert len(group["positions"]) == len(group["limits"]["lower"]) == count == 6
    assert all(len(q) == count for q in group["configurations"].values())
    assert group["positions"] == group["configurations"]["home"]
    assert group["tool_frames"][0].startswith("arm::")


@pytest.mark.parametrize("model", ["ur5e", "panda", "planar_l", "free_l"])
def test_models_are_described(client, model):
    assert model in client.get("/v1/models").json()["items"]
    shown = client.get(f"/v1/models/{model}").json()
    assert shown["name"] == model
    assert shown["groups"]
    assert shown["sources"]


def test_unknown_models_are_not_found(client):
    answer = client.get("/v1/models/ur5")
    assert answer.status_code == 404
    assert "ur5e" in answer.json()["evidence"]["nearest"]
