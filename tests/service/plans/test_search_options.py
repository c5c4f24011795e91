"""What a request may say about the search, over HTTP."""

import json
import threading

import numpy as np
import pytest

from planning.domain.planner.unavailable_planners import CLOSEST_PLANNERS
from planning.search.ompl.planner_list import planner_names

MAZE = {
    "robots": [{"name": "body", "model": "planar_l", "positions": [-0.35, -0.3, 0]}],
    "objects": [
        {"name": "wall", "shape": {"box": [0.02, 0.5, 0.2]}, "pose": {"position": [0, -0.25, 0]}}
    ],
    "configurations": {"beyond": {"group": "body", "positions": [0.3, -0.3, 0]}},
}
WALLED = {
    **MAZE,
    "objects": [
        {"name": "wall", "shape": {"box": [0.02, 9, 0.2]}, "pose": {"position": [0, 0, 0]}}
    ],
}
JOINT = "body::base_joint"


@pytest.fixture(scope="module")
def plan_in(client):
    scenes = {}

    def plan(search, scene=MAZE, wait=60, **fields):
        key = json.dumps(scene)
        if key not in scenes:
            scenes[key] = client.post("/v1/scenes", json=scene).json()["id"]
        request = {
            "scene": scenes[key],
            "group": "body",
            "goal": {"type": "configuration", "name": "beyond"},
            "refine": {"method": "none"},
            "search": {"allowed_planning_time": 60.0, **search},
            **fields,
        }
        return client.post(f"/v1/plans?wait={wait}", json=request)

    return plan


def test_planners_tell_types_and_bounds_of_their_parameters(client):
    items = {item["name"]: item for item in client.get("/v1/planners").json()["items"]}
    assert sorted(items) == sorted([*planner_names(), "GCS"])
    outside = set()
    for name, item in items.items():
        for parameter in item["parameters"]:
            kind, default = parameter["type"], parameter["default"]
            low, high = parameter["minimum"], parameter["maximum"]
            assert parameter["range"]
            if kind == "boolean":
                assert default in {"true", "false"}
                assert low is high is None
            elif not low <= float(default) <= (float("inf") if high is None else high):
                outside.add((name, parameter["name"], default))
    # 0 stands for what OMPL chooses.
    assert outside == {("PRM", "max_nearest_neighbors", "0")}
    bias = {p["name"]: p for p in items["RRT"]["parameters"]}["goal_bias"]
    assert (bias["type"], bias["minimum"], bias["maximum"]) == ("number", 0.0, 1.0)


COPPELIA = [
    "BiTRRT",
    "CForest",
    "EST",
    "LazyPRM",
    "LazyPRMstar",
    "LazyRRT",
    "LBTRRT",
    "PDST",
    "pRRT",
    "pSBL",
    "SBL",
    "SPARS",
    "SPARStwo",
    "STRIDE",
    "TRRT",
]


@pytest.mark.parametrize("name", COPPELIA)
def test_planners_that_the_wheel_lacks_are_refused_with_the_closest(plan_in, name):
    problem = plan_in({"planner": name}).json()
    assert problem["code"] == "unknown_name"
    assert "does not bind" in problem["detail"]
    (nearest,) = problem["evidence"]["nearest"]
    assert nearest in planner_names()
    assert problem["evidence"]["reason"].startswith(nearest)


def test_every_foreign_planner_is_foreign():
    assert sorted(CLOSEST_PLANNERS) == sorted(COPPELIA)
    assert not set(COPPELIA) & set(planner_names())


@pytest.mark.parametrize(
    ("name", "meant"), [("rrtconnect", "RRTConnect"), ("RRT*", "RRTstar"), ("prm", "PRM")]
)
def test_misspelt_planners_are_refused_with_the_nearest(plan_in, name, meant):
    problem = plan_in({"planner": ["PRM", name]}).json()
    assert problem["evidence"]["nearest"][0] == meant


@pytest.mark.parametrize(
    ("search", "kind"),
    [
        ({"weights": {"body::bas_joint": 2.0}}, "joint or block"),
        ({"bounds": {f"{JOINT}.w": [0, 1]}}, "position"),
        ({"spaces": {"body::joint": "position"}}, "planar or floating joint"),
        ({"planner": ["PRM", "RRT"], "parameters": {"gaol_bias": 0.1}}, "parameter"),
    ],
)
def test_names_that_the_group_lacks_are_refused(plan_in, search, kind):
    answer = plan_in(search)
    assert answer.status_code == 422
    assert answer.json()["code"] == "unknown_name"
    assert answer.json()["evidence"]["kind"] == kind


def test_several_planners_race_and_say_how(client, plan_in):
    names = ["KPIECE1", "RRTConnect"]
    job = plan_in({"planner": names, "attempts": 3, "objective": "duration"}).json()
    assert job["state"] == "succeeded", job["failure"]
    report = job["result"]["stages"]["search"]
    assert [entry["planner"] for entry in report["attempts_log"]] == [*names, names[0]]
    assert report["cost"] == min(
        entry["cost"] for entry in report["attempts_log"] if entry["outcome"] == "solved"
    )
    assert {"attempt_1", "attempt_2", "attempt_3"} <= set(job["timings"])
    events = client.get(f"/v1/plans/{job['id']}/events").text
    assert "event: best-so-far" in events


def test_all_options_together_give_a_proven_plan(plan_in):
    search = {
        "weights": {f"{JOINT}.angular": 0.5},
        "bounds": {f"{JOINT}.x": [-0.4, 0.4]},
        "spaces": {JOINT: "position"},
        "num_states": 300,
        "setup_time": 10.0,
        "solve_time": 10.0,
        "shortcut_time": 1.0,
        "interpolate_time": 10.0,
        "objective": "clearance",
        "approximate": True,
        "keep_graph": True,
        "on_cancel": "best",
    }
    job = plan_in(search).json()
    assert job["state"] == "succeeded", job["failure"]
    assert job["result"]["certificate"]["proven"]
    assert {row[2] for row in job["result"]["path"]} == {0.0}
    assert job["request"]["search"]["bounds"] == {f"{JOINT}.x": [-0.4, 0.4]}
    assert job["result"]["stages"]["search"]["interpolated"]
    assert len(job["result"]["path"]) >= 300
    assert {"setup", "solve", "shortcut", "interpolate"} <= set(job["timings"])


def test_no_time_to_interpolate_loses_no_path(plan_in):
    rough, cut = (
        plan_in(search).json() for search in ({}, {"num_states": 300, "interpolate_time": 0})
    )
    assert cut["state"] == "succeeded", cut["failure"]
    assert not cut["result"]["stages"]["search"]["interpolated"]
    assert cut["result"]["path"] == rough["result"]["path"]
    assert cut["digest"] == rough["digest"]


def test_a_setup_that_takes_too_long_is_told_as_such(plan_in):
    job = plan_in({"setup_time": 1e-9, "attempts": 2}).json()
    assert (job["state"], job["failure"]["code"]) == ("failed", "no_path_found")
    assert job["failure"]["stage"] == "search"
    evidence = job["failure"]["evidence"]
    assert (evidence["reason"], evidence["during"]) == ("setup", "setup")
    assert evidence["spent"] > evidence["budget"] == 1e-9


def test_the_graph_is_there_for_who_asked(client, plan_in):
    job = plan_in({"keep_graph": True, "planner": "PRM"}).json()
    graph = client.get(f"/v1/plans/{job['id']}/graph")
    assert graph.status_code == 200
    graph = graph.json()
    assert graph["planner"] == "PRM"
    assert graph["vertices"][graph["path"][-1]] == pytest.approx([0.3, -0.3, 0.0])
    assert all(i < j < len(graph["vertices"]) for i, j in graph["edges"])
    plain = plan_in({"planner": "PRM"}).json()
    assert plain["digest"] == job["digest"]
    refused = client.get(f"/v1/plans/{plain['id']}/graph")
    assert refused.status_code == 409
    assert "keep_graph" in refused.json()["detail"]


def test_a_failure_tells_how_near_it_came_and_keeps_the_graph_apart(client, plan_in):
    search = {"approximate": True, "keep_graph": True, "solve_time": 0.2}
    job = plan_in(search, WALLED).json()
    assert job["state"] == "failed"
    evidence = job["failure"]["evidence"]
    assert "graph" not in evidence
    near = evidence["approximate"]
    assert near["positions"] == near["path"][-1]
    assert near["positions"][0] < 0 < near["goal_distance"]
    graph = client.get(f"/v1/plans/{job['id']}/graph").json()
    assert graph["path"] == []
    assert len(graph["vertices"]) > 1


def test_a_cancel_gives_the_best_so_far_to_who_asked_for_it(client, plan_in):
    search = {"attempts": 100, "on_cancel": "best"}
    job = plan_in(search, wait=0).json()
    path = f"/v1/plans/{job['id']}"
    seen, told = threading.Event(), []
    with client.stream("GET", f"{path}/events") as events:
        for line in events.iter_lines():
            if line == "event: best-so-far" and not seen.is_set():
                seen.set()
                told.append(client.get(path).json()["best"])
                client.post(f"{path}/cancel")
    ended = client.get(path).json()
    assert seen.is_set()
    (best,) = told
    found = np.array(best["waypoints"])
    np.testing.assert_allclose(found[0], ended["result"]["path"][0], atol=1e-6)
    np.testing.assert_allclose(found[-1], [0.3, -0.3, 0.0], atol=1e-6)
    assert np.linalg.norm(np.diff(found, axis=0), axis=1).sum() == pytest.approx(best["length"])
    assert ended["best"] is None
    assert ended["state"] == "succeeded", ended["failure"]
    assert ended["result"]["stages"]["search"]["was_canceled"]
    assert ended["result"]["certificate"]["proven"]
