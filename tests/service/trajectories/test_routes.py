"""Paths and trajectories that a client brings along."""

import copy

import numpy as np
import pytest

ACCELERATION = {"frame": "arm::tcp", "acceleration": 1.0}


def post(client, scene, what, **body):
    body = {"scene": scene, "group": "arm", "allowed_time": 60, **body}
    return client.post(f"/v1/trajectories/{what}", json=body)


@pytest.fixture(scope="module")
def exact(client, solved):
    return client.get(f"/v1/plans/{solved['id']}/trajectory?polynomial=true").json()


def without(motion, *fields):
    return {name: value for name, value in motion.items() if name not in fields}


def test_what_a_plan_delivered_is_proven_again(client, scene, solved, exact):
    answer = post(client, scene, "certify", trajectory=exact).json()
    assert answer["interpolation"] == "polynomial"
    assert answer["certificate"]["proven"]
    expected = solved["result"]["certificate"]["min_clearance"]
    assert answer["certificate"]["min_clearance"] == pytest.approx(expected, abs=1e-3)
    assert answer["duration"] == exact["duration"]


def test_nearest_points_are_as_far_apart_as_they_are_said_to_be(client, scene, solved, exact):
    answer = post(client, scene, "certify", trajectory=exact).json()
    for certificate in (answer["certificate"], solved["result"]["certificate"]):
        apart = np.linalg.norm(np.subtract(*certificate["points"]))
        assert apart == pytest.approx(certificate["min_clearance"], abs=1e-3)
        assert certificate["proven_until"] == exact["duration"]
        assert certificate["first_unproven"] is None


def test_a_motion_into_the_table_is_proven_until_it_touches(client, scene, solved):
    begin = solved["result"]["start"]
    end = [*begin]
    end[1] += 1.2
    names = solved["result"]["trajectory"]["joint_names"]
    down = {"joint_names": names, "times": [0, 4], "positions": [begin, end]}
    still = {"velocities": [[0] * 6] * 2, "accelerations": [[0] * 6] * 2}
    answer = post(client, scene, "certify", trajectory=down | still)
    certificate = answer.json()["certificate"]
    assert not certificate["proven"]
    first = certificate["first_unproven"]
    assert 0 < certificate["proven_until"] < certificate["time"] < 4
    assert first["distance"] == pytest.approx(0.0, abs=1e-4)
    assert len(first["points"]) == 2
    assert certificate["min_clearance"] < first["distance"]


@pytest.mark.parametrize(
    ("left_out", "kind"),
    [
        (("polynomial",), "quintic"),
        (("polynomial", "accelerations"), "cubic"),
        (("polynomial", "accelerations", "velocities"), "cubic_spline"),
    ],
)
def test_samples_of_it_are_proven_at_lower_speed(client, scene, solved, left_out, kind):
    """Between samples the polynomial is another one: where acceleration jumps it overshoots."""
    slow = client.get(f"/v1/plans/{solved['id']}/trajectory?scale=0.5").json()
    answer = post(client, scene, "certify", trajectory=without(slow, *left_out)).json()
    assert answer["interpolation"] == kind
    assert answer["certificate"]["proven"], answer["certificate"]["checks"]


def test_columns_may_come_in_any_order(client, scene, exact):
    turned = without(exact, "polynomial")
    order = [3, 1, 0, 2, 5, 4]
    for field in ("positions", "velocities", "accelerations"):
        turned[field] = np.array(turned[field])[:, order].tolist()
    for field in ("joint_names", "velocity_names"):
        turned[field] = [turned[field][i] for i in order]
    same, other = (
        post(client, scene, "certify", trajectory=motion).json()
        for motion in (without(exact, "polynomial"), turned)
    )
    assert same == other


def test_a_motion_that_is_too_quick_or_ends_elsewhere_is_refused(client, scene, exact):
    quick = copy.deepcopy(exact["polynomial"])
    quick["breaks"] = (np.array(quick["breaks"]) * 0.9).tolist()
    powers = 0.9 ** -np.arange(len(quick["coefficients"][0]), dtype=float)
    quick["coefficients"] = (np.array(quick["coefficients"]) * powers[None, :, None]).tolist()
    goal = [q + 0.1 for q in exact["positions"][-1]]
    verdict = post(
        client, scene, "certify", trajectory={**exact, "polynomial": quick}, goal=goal
    ).json()["certificate"]
    assert not verdict["proven"]
    failed = {check["name"] for check in verdict["checks"] if not check["passed"]}
    assert {"acceleration", "goal"} <= failed
    assert "clearance" not in failed


def test_a_motion_through_an_obstacle_is_refused_with_the_pair(client, scene, exact):
    ends = {"times": [0, 30], "positions": [exact["positions"][0], [0.0] * 6]}
    verdict = post(client, scene, "certify", trajectory=ends).json()["certificate"]
    clearance = next(check for check in verdict["checks"] if check["name"] == "clearance")
    assert not verdict["proven"]
    assert not clearance["passed"]
    assert clearance["where"]


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_path_of_ones_own_is_timed_and_proven(client, scene, solved, method):
    path = solved["result"]["path"]
    answer = post(client, scene, "retime", waypoints=path, retime={"method": method}).json()
    assert answer["failure"] is None
    assert answer["certificate"]["proven"]
    positions = np.array(answer["trajectory"]["positions"])
    np.testing.assert_allclose(positions[[0, -1]], np.array(path)[[0, -1]], atol=1e-9)
    assert answer["stages"]["retime"]["method"] == method
    names = {check["name"] for check in answer["certificate"]["checks"]}
    assert ("jerk" in names) == (method == "ruckig")
    again = post(client, scene, "retime", waypoints=path, retime={"method": method})
    assert again.json() == answer


def test_a_path_through_an_obstacle_is_refused_with_reasons(client, scene, exact):
    answer = post(client, scene, "retime", waypoints=[exact["positions"][0], [0.0] * 6]).json()
    assert answer["trajectory"] is None
    assert answer["failure"]["code"] == "not_certified"
    checks = answer["failure"]["evidence"]["checks"]
    assert "clearance" in {check["name"] for check in checks}


def test_stops_and_robustness_are_told_where_they_are_asked_for(client, scene, exact):
    silent = post(client, scene, "certify", trajectory=exact).json()
    assert (silent["stage"]["stop"], silent["stage"]["robustness"]) == (None, None)
    wanted = {"stop_anywhere": True, "robustness": True}
    answer = post(client, scene, "certify", trajectory=exact, certify=wanted).json()
    assert answer["certificate"]["proven"]
    stop, robustness = answer["stage"]["stop"], answer["stage"]["robustness"]
    check = answer["certificate"]["checks"][-1]
    assert (check["name"], check["value"], check["bound"]) == ("stop", stop["time"], None)
    assert 0 < stop["time"] < exact["duration"]
    assert stop["frame"] == "arm::tcp"
    assert 0 < robustness["joint_error"] < robustness["obstacle_displacement"]
    assert {"block", "post"} & set(robustness["obstacle_pair"])
    hasty = {"stop_anywhere": True, "max_stopping_time": stop["time"] / 2}
    refused = post(client, scene, "certify", trajectory=exact, certify=hasty).json()
    assert not refused["certificate"]["proven"]
    assert refused["certificate"]["checks"][-1]["passed"] is False


@pytest.mark.parametrize("limits", [{"effort": True}, {"tool_limits": [ACCELERATION]}])
def test_stops_are_held_to_torques_and_to_accelerations_of_frames(client, scene, exact, limits):
    slow = np.array(exact["times"]) * 4
    samples = {"times": slow.tolist(), "positions": exact["positions"]}
    stops = [
        post(client, scene, "certify", trajectory=samples, certify={"stop_anywhere": True}, **more)
        for more in ({}, limits)
    ]
    free, held = (answer.json()["stage"]["stop"] for answer in stops)
    assert 0 < free["time"] <= held["time"] < slow[-1]
    assert (held["unheld"], held["unheld_at"]) == ("", None)
    hasty = {"max_stopping_time": held["time"] / 2}
    refused = post(client, scene, "certify", trajectory=samples, certify=hasty, **limits)
    checks = refused.json()["certificate"]["checks"]
    assert [check["name"] for check in checks if not check["passed"]] == ["stop"]


BAD = {
    "times that do not increase": {"times": [0, 0], "positions": [[0] * 6] * 2},
    "times that begin late": {"times": [1, 2], "positions": [[0] * 6] * 2},
    "a missing row": {"times": [0, 1, 2], "positions": [[0] * 6] * 2},
    "a missing column": {"times": [0, 1], "positions": [[0] * 5] * 2},
    "accelerations alone": {
        "times": [0, 1],
        "positions": [[0] * 6] * 2,
        "accelerations": [[0] * 6] * 2,
    },
    "an unknown joint": {
        "times": [0, 1],
        "positions": [[0] * 6] * 2,
        "joint_names": ["arm::elbow"] * 6,
    },
    "one joint twice": {
        "times": [0, 1],
        "positions": [[0] * 6] * 2,
        "joint_names": ["arm::elbow_joint"] * 6,
    },
    "a polynomial of another robot": {
        "times": [0, 1],
        "positions": [[0] * 6] * 2,
        "polynomial": {"breaks": [0, 1], "bases": [[0] * 7], "coefficients": [[[0] * 7]]},
    },
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_trajectory_is_refused_with_a_message(client, scene, name):
    answer = post(client, scene, "certify", trajectory=BAD[name])
    code = "unknown_name" if "unknown" in name else "problem_invalid"
    assert (answer.status_code, answer.json()["code"]) == (422, code)
    assert answer.json()["detail"]


def test_samples_of_a_floating_body_need_the_polynomial(client):
    document = {"name": "air", "robots": [{"name": "body", "model": "free_l"}]}
    made = client.post("/v1/scenes", json=document).json()["id"]
    q = [1, 0, 0, 0, 0, 0, 0.5]
    body = {"scene": made, "group": "body", "trajectory": {"times": [0, 1], "positions": [q, q]}}
    answer = client.post("/v1/trajectories/certify", json=body)
    assert answer.status_code == 422
    assert "polynomial" in answer.json()["detail"]


def test_a_duration_is_met_or_refused_and_explained(client, scene, solved):
    path = solved["result"]["path"]
    quick = post(client, scene, "retime", waypoints=path, retime={"explain": True}).json()
    least = quick["trajectory"]["duration"]
    explained = quick["stages"]["retime"]["explanation"]
    assert explained["intervals"][-1]["end"] == pytest.approx(least)
    assert explained["savings"][0]["seconds"] > 0
    slow = post(client, scene, "retime", waypoints=path, retime={"duration": 2 * least}).json()
    assert slow["trajectory"]["duration"] == pytest.approx(2 * least)
    assert slow["certificate"]["proven"]
    assert slow["stages"]["retime"]["explanation"] is None
    refused = post(client, scene, "retime", waypoints=path, retime={"duration": 0.1 * least})
    failure = refused.json()["failure"]
    assert failure["code"] == "retiming_failed"
    assert failure["evidence"]["least"] > 0.1 * least


@pytest.mark.parametrize("slow", [{"velocity_scale": 1e-9}, {"duration": 7200}])
def test_more_samples_than_anybody_reads_are_refused(client, scene, solved, slow):
    ways = {"waypoints": solved["result"]["path"]}
    refused = post(client, scene, "retime", **ways, retime=slow)
    assert (refused.status_code, refused.json()["code"]) == (422, "problem_invalid")
    for word in ("retime.sample_period", "retime.num_points"):
        assert word in refused.json()["detail"]
    few = post(client, scene, "retime", **ways, retime={**slow, "num_points": 50}).json()
    assert len(few["trajectory"]["times"]) == 50


@pytest.mark.parametrize("period", [0.01, 0.02])
def test_samples_are_asked_for_in_one_way(client, scene, solved, period):
    twice = {"sample_period": period, "num_points": 50}
    goal = {"type": "configuration", "name": "ready"}
    refusals = [
        post(client, scene, "retime", waypoints=solved["result"]["path"], retime=twice),
        client.post(
            "/v1/plans", json={"scene": scene, "group": "arm", "goal": goal, "retime": twice}
        ),
    ]
    for refused in refusals:
        assert (refused.status_code, refused.json()["code"]) == (422, "problem_invalid")
        for word in ("retime.sample_period", "retime.num_points"):
            assert word in refused.json()["detail"]


def test_constraints_deviation_and_stops_are_asked_for_with_a_path(client, scene, solved):
    path = solved["result"]["path"]
    kept = {"type": "keep_in", "frame": "arm::tcp", "box": {"size": [6.0, 6.0, 6.0]}}
    asked = {
        "path_constraints": [kept],
        "retime": {"deviation": 0},
        "certify": {"stop_anywhere": True},
    }
    answer = post(client, scene, "retime", waypoints=path, **asked).json()
    assert answer["failure"] is None
    assert answer["stages"]["retime"]["blend_deviation"] == 0
    assert answer["stages"]["certify"]["stop"] is not None
    name = "constraint 0: keep_in"
    assert name in {check["name"] for check in answer["certificate"]["checks"]}
    kept["box"]["size"] = [0.01, 0.01, 0.01]
    refused = post(client, scene, "retime", waypoints=path, **asked).json()["failure"]
    assert refused["code"] == "not_certified"
    assert name in {check["name"] for check in refused["evidence"]["checks"]}
    motion = answer["trajectory"]
    told = post(client, scene, "certify", trajectory=motion, path_constraints=[kept]).json()
    assert name in {c["name"] for c in told["certificate"]["checks"] if not c["passed"]}


def test_a_path_that_there_is_no_time_for_fails_in_a_stage_and_tells_its_timings(client, scene):
    waypoints = [[0.0, -1.5, 1.5, -1.5, -1.5, 0.0], [0.1, -1.5, 1.5, -1.5, -1.5, 0.1]]
    answer = post(client, scene, "retime", waypoints=waypoints, allowed_time=1e-6).json()
    failure = answer["failure"]
    assert (failure["code"], failure["stage"]) == ("deadline_exceeded", "retime")
    assert {"retime", "total"} <= set(failure["timings"])
    assert answer["cut_short"] == []
