"""Every job says how often it was begun with, and when its end was requested."""

import pytest

from tests.service.conftest import BLOCK_SCENE
from tests.service.servers import endless, until


@pytest.fixture
def blocked(client):
    """The id of a plan that goes on until it is canceled."""

    class Asked:
        """A client of the server, as `endless` wants one."""

        def add_scene(self, text):
            headers = {"Content-Type": "application/yaml"}
            made = client.post("/v1/scenes", content=text, headers=headers).json()
            return type("Scene", (), made)

    request = endless(Asked())
    name = client.post("/v1/plans", json=request).json()["id"]
    yield name
    client.post(f"/v1/plans/{name}/cancel")


def test_a_job_that_has_ended_was_begun_with_once(client, solved, few_regions):
    for path in ("/v1/plans/{}".format(solved["id"]), "/v1/regions/{}".format(few_regions["id"])):
        told = client.get(path).json()
        assert (told["attempts"], told["cancel_requested_at"]) == (1, None)
    # A scene of its own: where its robot is afterwards matters to the tests of another one.
    scene = client.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]
    goal = {"type": "configuration", "name": "ready"}
    request = {"scene": scene, "group": "arm", "goal": goal}
    plan = client.post("/v1/plans?wait=60", json=request).json()
    body = {"plan": plan["id"], "driver": "simulated", "speed": 100.0}
    told = client.post("/v1/executions?wait=60", json=body).json()
    assert (told["attempts"], told["cancel_requested_at"]) == (1, None)


def test_the_first_request_for_the_end_is_told_at_once_and_stays(client, blocked):
    path = f"/v1/plans/{blocked}"
    assert client.get(path).json()["cancel_requested_at"] is None
    until(lambda: client.get(path).json()["attempts"] == 1)
    first = client.post(f"{path}/cancel").json()["cancel_requested_at"]
    again = client.post(f"{path}/cancel").json()["cancel_requested_at"]
    assert first == again is not None
    ended = until(lambda: (job := client.get(path).json())["state"] == "canceled" and job)
    assert ended["cancel_requested_at"] == first
    assert ended["created_at"] < first < ended["finished_at"]
    listed = client.get("/v1/plans?state=canceled&limit=200").json()["items"]
    assert first in {item["cancel_requested_at"] for item in listed if item["id"] == blocked}


def test_a_plan_that_waits_is_canceled_without_an_attempt(client, blocked):
    until(lambda: client.get(f"/v1/plans/{blocked}").json()["attempts"] == 1)
    request = client.get(f"/v1/plans/{blocked}").json()["request"]
    more = [client.post("/v1/plans", json=request).json()["id"] for _ in range(10)]
    told = [client.post(f"/v1/plans/{name}/cancel").json() for name in reversed(more)]
    waited = [job for job in told if job["started_at"] is None]
    assert waited
    for job in waited:
        assert job["attempts"] == 0
        assert job["cancel_requested_at"] is not None
