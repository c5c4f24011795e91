"""Regions over HTTP: grown as a job, listed, canceled, and used by plans."""

import uuid

import pytest

from service.client.events import decode_events

# An L in a square with a wall across most of it.
SCENE = {
    "name": "square",
    "robots": [{"name": "body", "model": "planar_l", "positions": [0.3, -0.35, 0.0]}],
    "objects": [
        {"name": "wall", "shape": {"box": [0.8, 0.02, 0.06]}, "pose": {"position": [0.2, 0, 0.03]}}
    ],
    "configurations": {"beyond": {"group": "body", "positions": [0.3, 0.3, 0.0]}},
}
REQUEST = {"group": "body", "num_regions": 12, "num_free": 500, "iterations": 1, "seed": 2}
ENDLESS = {**REQUEST, "num_regions": 1000, "coverage": 1.0, "num_free": 200_000}


@pytest.fixture(scope="module")
def square(client):
    return client.post("/v1/scenes", json=SCENE).json()["id"]


@pytest.fixture(scope="module")
def grown(client, square):
    answer = client.post(f"/v1/scenes/{square}/regions?wait=60", json=REQUEST)
    assert answer.status_code == 200, answer.text
    job = answer.json()
    assert job["state"] == "succeeded", job["failure"]
    assert answer.headers["location"] == f"/v1/regions/{job['id']}"
    return job


def plan_of(client, scene, headers=None, **fields):
    search = {"planner": "GCS", "allowed_planning_time": 60.0, **fields.pop("search", {})}
    beyond = {"type": "configuration", "name": "beyond"}
    goal = fields.pop("goal", beyond)
    request = {"scene": scene, "group": "body", "goal": goal, "search": search, **fields}
    return client.post("/v1/plans?wait=60", json=request, headers=headers)


def test_grown_regions_say_everything(client, square, grown):
    result, summary = grown["result"], grown["summary"]
    assert len(result["regions"]) == summary["num_regions"] == 12
    assert len(result["portals"]) == summary["num_portals"] > 0
    assert 0 < summary["coverage"] <= 1
    assert 0 < summary["coverage_error"] < 0.02
    assert summary["stopped_by"] == "num_regions"
    scene = client.get(f"/v1/scenes/{square}").json()
    assert summary["scene"] == scene["digest"]
    assert client.get(f"/v1/regions/{grown['id']}").json() == grown
    listed = client.get(f"/v1/scenes/{square}/regions").json()["items"]
    assert [item["id"] for item in listed] == [grown["id"]]
    assert listed[0]["summary"] == summary
    assert "result" not in listed[0]
    with client.stream("GET", f"/v1/regions/{grown['id']}/events") as answer:
        types = [event.type for event in decode_events(answer)]
    assert types[0] == "queued"
    assert types[-1] == "finished"


def test_a_plan_uses_the_newest_that_fit_and_is_repeatable(client, square, grown):
    first = plan_of(client, square).json()
    assert first["state"] == "succeeded", first["failure"]
    search = first["result"]["stages"]["search"]
    assert search["planner"] == "GCS"
    assert search["regions"]["is_inside"]
    assert search["regions"]["digest"] == grown["summary"]["digest"]
    assert first["result"]["certificate"]["proven"]
    again = plan_of(client, square, search={"regions": grown["id"]}).json()
    assert again["digest"] == first["digest"]


def test_a_plan_says_which_regions_it_was_given(client):
    """Asked again it has the same bytes, whatever has grown since; its key stands for both."""
    there = client.post("/v1/scenes", json={**SCENE, "margin": 0.003}).json()["id"]
    path = f"/v1/scenes/{there}/regions?wait=60"
    few = {**REQUEST, "num_regions": 2, "num_free": 100}
    old = client.post(path, json=few).json()
    headers = {"Idempotency-Key": uuid.uuid4().hex}
    first = plan_of(client, there, headers).json()
    assert first["request"]["search"]["regions"] == old["id"]
    newer = client.post(path, json={**few, "seed": 5}).json()
    assert newer["summary"]["digest"] != old["summary"]["digest"]
    assert plan_of(client, there, headers).json()["id"] == first["id"]
    again = client.post("/v1/plans?wait=60", json=first["request"]).json()
    assert again["digest"] == first["digest"]
    used = again["result"]["stages"]["search"]["regions"]["digest"]
    assert used == old["summary"]["digest"]


def test_a_scene_with_the_same_content_shares_them(client, grown):
    twin = client.post("/v1/scenes", json=SCENE).json()["id"]
    found = plan_of(client, twin).json()
    used = found["result"]["stages"]["search"]["regions"]["digest"]
    assert used == grown["summary"]["digest"]


def test_without_regions_that_fit_a_plan_is_refused_and_says_what_is_there(client, square, grown):
    moved = {**SCENE, "margin": 0.001}
    other = client.post("/v1/scenes", json=moved).json()["id"]
    for answer in (
        plan_of(client, other),
        plan_of(client, square, margin=0.05),
        plan_of(client, other, search={"regions": grown["id"]}),
    ):
        assert answer.status_code == 409
        problem = answer.json()
        assert problem["code"] == "no_regions"
        assert "/regions" in problem["detail"]
    assert [entry["id"] for entry in problem["evidence"]["there"]] == [grown["id"]]
    assert plan_of(client, square, search={"regions": "reg_nothing"}).status_code == 404


@pytest.mark.parametrize("planner", ["RRTConnect", ["RRTConnect", "PRM"]])
def test_regions_that_nobody_would_look_at_are_refused(client, square, grown, planner):
    for name in (grown["id"], "bogus"):
        answer = plan_of(client, square, search={"planner": planner, "regions": name})
        assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
        assert answer.json()["evidence"] == {"field": "search.regions"}


def test_where_nothing_has_grown_nothing_fits(client):
    """However new it is: the newest that have regions are taken, or none."""
    there = client.post("/v1/scenes", json={**SCENE, "margin": 0.002}).json()["id"]
    path = f"/v1/scenes/{there}/regions?wait=60"
    empty = client.post(path, json={**REQUEST, "padding": 1.0}).json()
    assert empty["summary"]["num_regions"] == 0
    for search in ({}, {"regions": empty["id"]}):
        problem = plan_of(client, there, search=search).json()
        assert problem["code"] == "no_regions"
        assert [entry["num_regions"] for entry in problem["evidence"]["there"]] == [0]
    few = client.post(path, json={**REQUEST, "num_regions": 1, "along": "nothing"}).json()
    client.post(path, json={**REQUEST, "padding": 1.0})
    found = plan_of(client, there).json()
    used = found["result"]["stages"]["search"]["regions"]["digest"]
    assert used == few["summary"]["digest"]


def test_what_floats_has_no_regions_and_is_told_so_at_once(client):
    robots = [{"name": "body", "model": "free_l"}]
    there = client.post("/v1/scenes", json={"robots": robots}).json()["id"]
    goal = {"type": "joint", "positions": [[1.0, 0, 0, 0, 0, 0, 0.1]]}
    for answer in (
        plan_of(client, there, goal=goal),
        client.post(f"/v1/scenes/{there}/regions", json={"group": "body"}),
    ):
        assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
        assert "floating" in answer.json()["detail"]


def test_planners_tell_that_gcs_needs_regions(client):
    planners = {entry["name"]: entry for entry in client.get("/v1/planners").json()["items"]}
    assert [name for name, entry in planners.items() if entry["needs_regions"]] == ["GCS"]


def test_a_cancel_ends_the_growth_and_the_stages_until_then_are_timed(client, square):
    job = client.post(f"/v1/scenes/{square}/regions", json=ENDLESS).json()
    path = f"/v1/regions/{job['id']}"
    with client.stream("GET", f"{path}/events") as answer:
        events = decode_events(answer)
        next(event for event in events if event.data.get("stage") == "regions")
        assert client.post(f"{path}/cancel").status_code == 200
        list(events)
    canceled = client.get(path).json()
    assert canceled["state"] == "canceled"
    assert canceled["failure"]["stage"] == "regions"
    assert set(canceled["timings"]) == {"load", "regions", "total"}
    assert canceled["timings"] == canceled["failure"]["timings"]
    assert canceled["timings"]["total"] >= canceled["timings"]["regions"] > 0


def test_what_does_not_exist_is_named(client, square, scene):
    path = f"/v1/scenes/{square}/regions"
    answer = client.post(path, json={**REQUEST, "group": "leg"})
    assert (answer.status_code, answer.json()["code"]) == (409, "unknown_name")
    answer = client.post(path, json={**REQUEST, "bounds": {"x": [0, 1]}})
    assert answer.json()["code"] == "unknown_name"
    answer = client.post(path, json={**REQUEST, "bounds": {"body::base_joint.yaw": [-4, 4]}})
    assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
    assert client.post(path, json={**REQUEST, "num_regions": 0}).status_code == 422
    assert client.get("/v1/scenes/scn_nothing/regions").status_code == 404
    for verb, tail in (("GET", ""), ("POST", "/cancel"), ("GET", "/events")):
        assert client.request(verb, f"/v1/regions/reg_nothing{tail}").status_code == 404
