"""All lists have pages in the same way: a limit, an opaque cursor, and filters where they fit."""

import pytest

from service.api.paging import cursor_of, sequence_of
from tests.service.pages import walk

ARM = {"name": "lists", "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}]}


@pytest.fixture(scope="module")
def scene(client):
    """The id of a scene with two plans, a batch of one more, an execution and regions."""
    scene = client.post("/v1/scenes", json=ARM).json()["id"]
    request = {"scene": scene, "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    request["search"] = {"allowed_planning_time": 60.0}
    batch = {"problems": [{**request, "seed": 1}]}
    assert client.post("/v1/plans/batch?wait=60", json=batch).is_success
    plan = client.post("/v1/plans?wait=60", json=request).json()
    client.post(f"/v1/plans/{plan['id']}/reverse?wait=60")
    body = {"plan": plan["id"], "driver": "simulated", "speed": 100.0}
    client.post("/v1/executions?wait=60", json=body)
    grow = {"group": "arm", "num_regions": 1, "num_free": 100, "iterations": 1, "along": "nothing"}
    grow["allowed_time"] = 60.0
    assert client.post(f"/v1/scenes/{scene}/regions?wait=60", json=grow).is_success
    for host in (34, 35):
        hook = {"url": f"https://93.184.216.{host}/hook"}
        assert client.post("/v1/webhooks", json=hook).status_code == 201
    return scene


@pytest.fixture(
    params=[
        "/v1/plans",
        "/v1/batches",
        "/v1/executions",
        "/v1/scenes",
        "/v1/scenes/{scene}/regions",
        "/v1/webhooks",
    ]
)
def path(request, scene):
    return request.param.format(scene=scene)


def test_pages_join_up_and_the_last_one_has_no_next(client, path):
    whole = client.get(f"{path}?limit=200").json()
    names = [item["id"] for item in whole["items"]]
    assert names
    assert whole["next"] is None
    assert [item["id"] for item in walk(client, path, limit=1)] == names
    assert client.get(f"{path}?limit={len(names)}").json()["next"] is None


def test_cursors_are_opaque_and_those_of_older_servers_work(client):
    client.post("/v1/scenes", json=ARM)
    page = client.get("/v1/scenes?limit=1").json()
    assert not page["next"].isdecimal()
    following = client.get(f"/v1/scenes?limit=1&cursor={page['next']}").json()
    old = client.get(f"/v1/scenes?limit=1&cursor={sequence_of(page['next'])}").json()
    assert following["items"]
    assert following == old


def test_scenes_are_filtered_by_name(client):
    made = [client.post("/v1/scenes", json={**ARM, "name": f"list-{k}"}).json() for k in "aba"]
    wanted = [made[2]["id"], made[0]["id"]]
    edit = {"op": "add", "object": {"name": "ball", "shape": {"sphere": 0.1}}}
    client.patch(f"/v1/scenes/{wanted[1]}", json={"operations": [edit]})
    asked = "/v1/scenes?name=list-a"
    assert [item["id"] for item in client.get(asked).json()["items"]] == wanted
    assert [item["id"] for item in walk(client, asked, limit=1)] == wanted
    assert client.get("/v1/scenes?name=list").json()["items"] == []


@pytest.mark.parametrize("sequence", [0, 1, 77, 2**59])
def test_a_cursor_holds_where_a_page_ends(sequence):
    assert sequence_of(cursor_of(sequence)) == sequence
    assert sequence_of(str(sequence)) == sequence


@pytest.mark.parametrize("cursor", ["x", "-1", "1e3", "%20", "9" * 19, "YmVmb3Jl", "a" * 65, ""])
def test_what_is_no_cursor_is_refused(client, path, cursor):
    answer = client.get(f"{path}?cursor={cursor}")
    assert answer.status_code == 422, answer.text
    assert answer.json()["evidence"]["faults"][0]["path"] == "query.cursor"


@pytest.mark.parametrize(
    ("path", "state", "count"),
    [
        ("/v1/plans?scene={scene}", "succeeded", 3),
        ("/v1/plans?scene={scene}", "failed", 0),
        ("/v1/executions?scene={scene}", "succeeded", 1),
        ("/v1/executions?scene={scene}", "aborted", 0),
        ("/v1/executions?scene={scene}", "executing", 0),
        ("/v1/scenes/{scene}/regions?limit=9", "succeeded", 1),
        ("/v1/scenes/{scene}/regions?limit=9", "running", 0),
    ],
)
def test_lists_of_jobs_are_filtered_by_state(client, scene, path, state, count):
    items = client.get(f"{path.format(scene=scene)}&state={state}").json()["items"]
    assert [item["state"] for item in items] == [state] * count


def test_executions_are_filtered_while_they_move(client, scene):
    """A paused execution is found as paused, and not as executing."""
    plans = client.get(f"/v1/plans?scene={scene}").json()["items"]
    reverse = max(plans, key=lambda plan: plan["created_at"])["id"]
    body = {"plan": reverse, "driver": "simulated", "speed": 0.05}
    name = client.post("/v1/executions", json=body).json()["id"]
    client.post(f"/v1/executions/{name}/pause")
    while client.get(f"/v1/executions/{name}").json()["state"] != "paused":
        pass
    try:
        listed = f"/v1/executions?scene={scene}&state="
        assert [item["id"] for item in client.get(f"{listed}paused").json()["items"]] == [name]
        assert client.get(f"{listed}executing").json()["items"] == []
        assert client.get(f"{listed}accepted").json()["items"] == []
    finally:
        client.post(f"/v1/executions/{name}/cancel")


@pytest.mark.parametrize("path", ["/v1/plans", "/v1/executions", "/v1/scenes/{scene}/regions"])
def test_a_state_that_there_is_not_is_refused(client, scene, path):
    answer = client.get(f"{path.format(scene=scene)}?state=nothing")
    assert answer.status_code == 422
    assert answer.json()["evidence"]["faults"][0]["path"] == "query.state"
