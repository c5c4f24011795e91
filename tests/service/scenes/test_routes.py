"""Scenes over HTTP."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from planning import bundled_folder
from tests.profiles import pairs
from tests.service.conftest import BLOCK_SCENE
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


def test_the_last_page_of_scenes_has_no_next(client):
    """Also where it is full: a client that follows `next` asks for no empty page."""
    client.post("/v1/scenes", json=ARM)
    num_scenes = len(walk(client, "/v1/scenes", limit=200))
    page = client.get(f"/v1/scenes?limit={num_scenes}").json()
    assert len(page["items"]) == num_scenes
    assert page["next"] is None
    if num_scenes > 1:
        assert client.get(f"/v1/scenes?limit={num_scenes - 1}").json()["next"] is not None


ETAG = {"operations": [{"op": "set_positions", "robot": "arm", "positions": [0.1] * 6}]}


def posted(client):
    answer = client.post("/v1/scenes", json=ARM)
    return f"/v1/scenes/{answer.json()['id']}", answer.headers["etag"]


def test_a_scene_has_a_strong_etag_of_its_revision(client):
    path, etag = posted(client)
    assert etag.startswith('"')
    assert client.get(path).headers["etag"] == etag
    second = client.patch(path, json=ETAG).headers["etag"]
    assert second != etag
    assert client.get(path).headers["etag"] == second
    assert client.get(f"{path}?revision=1").headers["etag"] == etag
    assert posted(client)[1] != etag  # another scene of the same content


@pytest.mark.parametrize("match", ["{}", "*", '"other", {}'])
def test_what_matches_is_edited_and_deleted(client, match):
    path, etag = posted(client)
    answer = client.patch(path, json=ETAG, headers={"If-Match": match.format(etag)})
    assert (answer.status_code, answer.json()["revision"]) == (200, 2)
    headers = {"If-Match": match.format(answer.headers["etag"])}
    assert client.delete(path, headers=headers).status_code == 204


@pytest.mark.parametrize("match", ['"other"', "W/{}", "other"])
def test_what_does_not_match_changes_nothing(client, match):
    path, etag = posted(client)
    before = client.get(path).json()
    for verb, body in (("PATCH", ETAG), ("DELETE", None)):
        headers = {"If-Match": match.format(etag)}
        answer = client.request(verb, path, json=body, headers=headers)
        assert (answer.status_code, answer.json()["code"]) == (412, "revision_mismatch")
        assert answer.json()["evidence"] == {
            "revision": 1,
            "etag": etag,
            "asked": headers["If-Match"],
        }
    assert client.get(path).json() == before


def test_an_edit_of_a_revision_that_is_not_the_latest_does_not_match(client):
    path, etag = posted(client)
    client.patch(path, json=ETAG)
    for verb, body in (("PATCH", ETAG), ("DELETE", None)):
        answer = client.request(verb, path, json=body, headers={"If-Match": etag})
        assert (answer.status_code, answer.json()["code"]) == (412, "revision_mismatch")
        assert answer.json()["evidence"]["revision"] == 2
    gone = client.delete(f"{path}x", headers={"If-Match": etag})
    assert gone.status_code == 404


def test_of_edits_at_once_that_match_one_revision_one_is_made(client):
    path, etag = posted(client)
    with ThreadPoolExecutor(4) as pool:
        asked = [
            pool.submit(client.patch, path, json=ETAG, headers={"If-Match": etag}) for _ in range(4)
        ]
    assert sorted(one.result().status_code for one in asked) == [200, 412, 412, 412]
    assert client.get(path).json()["revision"] == 2


def test_an_unchanged_scene_is_not_sent_again(client):
    path, etag = posted(client)
    answer = client.get(path, headers={"If-None-Match": etag})
    assert (answer.status_code, answer.content) == (304, b"")
    assert answer.headers["etag"] == etag
    assert client.get(path, headers={"If-None-Match": f"W/{etag}"}).status_code == 304
    assert client.get(path, headers={"If-None-Match": '"other"'}).status_code == 200
    client.patch(path, json=ETAG)
    assert client.get(path, headers={"If-None-Match": etag}).status_code == 200


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


def test_what_is_deleted_is_answered_without_a_content_type(client):
    """There is no body, so no type of one."""
    scene = client.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]
    answer = client.delete(f"/v1/scenes/{scene}")
    assert (answer.status_code, answer.content) == (204, b"")
    assert "content-type" not in answer.headers
