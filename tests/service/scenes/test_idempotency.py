"""A scene that is posted twice with one idempotency key is one scene."""

import threading
import uuid
from concurrent.futures import ThreadPoolExecutor

import pytest

ARM = {"name": "keyed", "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}]}


@pytest.fixture
def headers():
    return {"Idempotency-Key": uuid.uuid4().hex}


def test_the_same_key_and_body_are_the_same_scene(client, headers):
    first = client.post("/v1/scenes", json=ARM, headers=headers)
    again = client.post("/v1/scenes", json=ARM, headers=headers)
    assert (first.status_code, again.status_code) == (201, 201)
    assert again.json() == first.json()
    assert again.headers["location"] == first.headers["location"]
    assert client.post("/v1/scenes", json=ARM).json()["id"] != first.json()["id"]


def test_another_body_is_refused(client, headers):
    first = client.post("/v1/scenes", json=ARM, headers=headers).json()
    for changed in ({"json": ARM | {"name": "other"}}, {"content": b"name: keyed\nrobots: []"}):
        sent = headers | ({} if "json" in changed else {"Content-Type": "application/yaml"})
        told = client.post("/v1/scenes", headers=sent, **changed)
        assert (told.status_code, told.json()["code"]) == (409, "idempotency_conflict")
        assert told.json()["evidence"] == {"key": headers["Idempotency-Key"], "scene": first["id"]}


def test_the_scene_is_told_as_it_is_by_now(client, headers):
    first = client.post("/v1/scenes", json=ARM, headers=headers).json()
    move = {"op": "set_positions", "robot": "arm", "positions": {"shoulder_pan_joint": 0.3}}
    path = f"/v1/scenes/{first['id']}"
    edited = client.patch(path, json={"operations": [move]}).json()
    assert edited.pop("executions") == []
    assert client.post("/v1/scenes", json=ARM, headers=headers).json() == edited


def test_a_deleted_scene_gives_its_key_free(client, headers):
    first = client.post("/v1/scenes", json=ARM, headers=headers).json()
    assert client.delete(f"/v1/scenes/{first['id']}").status_code == 204
    again = client.post("/v1/scenes", json=ARM | {"name": "new"}, headers=headers)
    assert again.status_code == 201
    assert again.json()["id"] != first["id"]


def test_posts_at_once_are_one_scene(client, headers):
    gate = threading.Barrier(4)

    def post(_):
        gate.wait()
        return client.post("/v1/scenes", json=ARM, headers=headers)

    with ThreadPoolExecutor(4) as threads:
        told = list(threads.map(post, range(4)))
    assert {answer.status_code for answer in told} == {201}
    assert len({answer.json()["id"] for answer in told}) == 1


@pytest.mark.parametrize("key", ["", "k" * 201])
def test_keys_have_1_to_200_characters(client, key):
    assert client.post("/v1/scenes", json=ARM, headers={"Idempotency-Key": key}).status_code == 422
