"""Objectives of refinement over HTTP: what a plan reports of them, for both methods."""

import pytest

PAYLOAD = {"frame": "arm::tool0", "mass": 3.0, "center_of_mass": [0, 0, 0.1]}
NAMES = {"duration", "smoothness", "energy", "path_length"}


def ask(client, scene, refine, retime=None):
    body = {
        "scene": scene,
        "group": "arm",
        "goal": {"type": "configuration", "name": "ready"},
        "refine": refine,
        "retime": retime or {},
        "search": {"allowed_planning_time": 60.0},
        "seed": 3,
    }
    return client.post("/v1/plans?wait=60", json=body).json()


@pytest.mark.parametrize("method", ["trajopt", "drake"])
def test_the_report_tells_each_objective_before_and_after(client, scene, method):
    objective = {"smoothness": 1, "max_duration": 2.5}
    job = ask(client, scene, {"method": method, "objective": objective})
    assert job["state"] == "succeeded", job["failure"]
    report = job["result"]["stages"]["refine"]
    assert set(report["before"]) == set(report["after"]) == NAMES
    assert all(value > 0 for part in ("before", "after") for value in report[part].values())
    assert report["improved"]
    assert report["after"]["smoothness"] < 0.5 * report["before"]["smoothness"]
    assert report["before"]["duration"] < report["after"]["duration"] <= 2.5 * (1 + 1e-6)
    assert job["result"]["certificate"]["proven"]


def test_energy_is_of_the_arm_with_what_it_carries(client, scene):
    refine = {"objective": {"energy": 1, "max_duration": 2.5}}
    light, heavy = (
        ask(client, scene, refine, {"payload": load})["result"]["stages"]["refine"]
        for load in (None, PAYLOAD)
    )
    assert light["after"]["energy"] < light["before"]["energy"]
    assert heavy["after"]["energy"] < heavy["before"]["energy"]
    assert light["after"]["energy"] < heavy["after"]["energy"]


def test_jerks_count_where_accelerations_have_no_jumps(client, scene):
    objective = {"smoothness": 1, "derivative": "jerk", "max_duration": 3}
    job = ask(client, scene, {"objective": objective}, {"method": "ruckig"})
    assert job["state"] == "succeeded", job["failure"]
    report = job["result"]["stages"]["refine"]
    assert report["after"]["smoothness"] < 0.5 * report["before"]["smoothness"]


@pytest.mark.parametrize("method", ["trajopt", "drake"])
def test_less_time_than_the_limits_allow_is_a_failure_with_the_least(client, scene, method):
    objective = {"smoothness": 1, "max_duration": 0.1}
    job = ask(client, scene, {"method": method, "objective": objective})
    assert job["state"] == "failed"
    assert job["failure"]["code"] == "retiming_failed"
    assert job["failure"]["evidence"]["least"] > 0.1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"goal": {"type": "line", "displacement": {"vector": [0, 0, 0.05]}}}, "along lines"),
        ({"retime": {"duration": 3.0}}, "retime.duration is 3 s"),
    ],
)
def test_what_cannot_be_optimized_is_refused_at_once(client, scene, change, message):
    body = {
        "scene": scene,
        "group": "arm",
        "goal": {"type": "configuration", "name": "ready"},
        "refine": {"objective": {"smoothness": 1, "max_duration": 2.5}},
    }
    answer = client.post("/v1/plans", json=body | change)
    assert answer.status_code == 422
    assert message in answer.json()["detail"]
