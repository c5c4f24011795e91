"""An idempotency key stands for all that a request says, in its body and in its address."""

import uuid

import pytest

READY = {"type": "configuration", "name": "ready"}


@pytest.fixture
def headers():
    return {"Idempotency-Key": uuid.uuid4().hex}


def refused(answer):
    return (answer.status_code, answer.json()["code"]) == (409, "idempotency_conflict")


def test_a_key_gives_the_same_plan_again(client, scene, headers):
    request = {"scene": scene, "group": "arm", "goal": READY}
    first = client.post("/v1/plans", json=request, headers=headers).json()
    again = client.post("/v1/plans", json=request, headers=headers)
    assert again.json()["id"] == first["id"]
    assert refused(client.post("/v1/plans", json={**request, "seed": 9}, headers=headers))


def test_a_key_gives_the_way_back_of_one_plan_only(client, solved, headers):
    twin = client.post("/v1/plans?wait=60", json=solved["request"]).json()
    assert twin["state"] == "succeeded"
    assert twin["digest"] == solved["digest"]
    first = client.post(f"/v1/plans/{solved['id']}/reverse?wait=60", headers=headers).json()
    again = client.post(f"/v1/plans/{solved['id']}/reverse", headers=headers).json()
    assert again["id"] == first["id"]
    assert refused(client.post(f"/v1/plans/{twin['id']}/reverse", headers=headers))
    assert refused(client.post("/v1/plans", json=first["request"], headers=headers))


def test_a_key_gives_the_regions_of_one_scene_only(client, scene, headers):
    request = {"group": "arm", "num_regions": 1, "num_free": 100, "allowed_time": 0.001}
    first = client.post(f"/v1/scenes/{scene}/regions?wait=60", json=request, headers=headers).json()
    again = client.post(f"/v1/scenes/{scene}/regions", json=request, headers=headers).json()
    assert again["id"] == first["id"]
    robots = [{"name": "arm", "model": "ur5e", "positions": "home"}]
    other = client.post("/v1/scenes", json={"robots": robots}).json()["id"]
    answer = client.post(f"/v1/scenes/{other}/regions", json=request, headers=headers)
    assert refused(answer)


def test_a_key_gives_the_same_webhook_and_its_secret_again(client, headers):
    request = {"url": "https://93.184.216.34/hook", "events": ["plan.finished"]}
    first = client.post("/v1/webhooks", json=request, headers=headers)
    again = client.post("/v1/webhooks", json=request, headers=headers)
    assert (first.status_code, again.status_code) == (201, 201)
    assert again.json() == first.json()
    told = client.post("/v1/webhooks", json={"url": request["url"]}, headers=headers)
    assert refused(told)
    assert told.json()["evidence"] == {
        "key": headers["Idempotency-Key"],
        "webhook": first.json()["id"],
    }
    assert client.post("/v1/webhooks", json=request).json()["id"] != first.json()["id"]
    assert client.delete(f"/v1/webhooks/{first.json()['id']}").status_code == 204
    assert client.post("/v1/webhooks", json=request, headers=headers).status_code == 201
