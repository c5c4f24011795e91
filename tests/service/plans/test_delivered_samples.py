"""What is delivered is proven as it is delivered, or marked; columns are named once for all."""

import numpy as np
import pytest

TURNED = [5, 4, 3, 2, 1, 0]
READ = {
    "linear": ("positions",),
    "cubic": ("positions", "velocities"),
    "quintic": ("positions", "velocities", "accelerations"),
}


def certified(client, scene, trajectory, **body):
    request = {"scene": scene, "group": "arm", "trajectory": trajectory, "allowed_time": 30, **body}
    answer = client.post("/v1/trajectories/certify", json=request)
    assert answer.status_code == 200, answer.text
    return answer.json()


def refused(client, scene, trajectory):
    request = {"scene": scene, "group": "arm", "trajectory": trajectory}
    answer = client.post("/v1/trajectories/certify", json=request)
    assert answer.status_code == 422, answer.text
    return answer.json()


def failed_in(certificate):
    return {check["name"] for check in certificate["checks"] if not check["passed"]}


def given_back(client, scene, motion, kind, **body):
    """Return the certificate of samples, of which a receiver has as much as it needs."""
    told = {"times": motion["times"], **{rows: motion[rows] for rows in READ[kind]}}
    return certified(client, scene, {**told, "interpolation": kind}, **body)["certificate"]


def test_what_a_plan_delivers_is_proven_as_it_is(client, scene, solved):
    motion = solved["result"]["trajectory"]
    assert [proof["kind"] for proof in motion["interpolations"]] == list(READ)
    for proof in motion["interpolations"]:
        assert proof["proven"], proof
        assert proof["failed"] == []
        assert proof["up_to_period"] >= np.diff(motion["times"]).max()
        assert given_back(client, scene, motion, proof["kind"])["proven"]
    assert certified(client, scene, motion)["interpolation"] == "quintic"
    assert certified(client, scene, motion)["certificate"]["proven"]


@pytest.mark.parametrize("retime", [{}, {"method": "ruckig"}, {"acceleration_scale": 0.05}])
def test_a_path_that_is_timed_is_delivered_as_proven(client, scene, solved, retime):
    path = solved["result"]["path"]
    body = {"scene": scene, "group": "arm", "waypoints": path, "retime": retime}
    motion = client.post("/v1/trajectories/retime", json=body).json()["trajectory"]
    held = {"limit_jerk": retime.get("method") == "ruckig"}
    held["acceleration_scale"] = retime.get("acceleration_scale", 1.0)
    for proof in motion["interpolations"]:
        again = given_back(client, scene, motion, proof["kind"], **held)
        # Straight lines have no accelerations to hold them to, however it was asked.
        assert proof["proven"] == again["proven"]
        assert proof["kind"] == "cubic" or proof["proven"], proof


@pytest.mark.parametrize("query", ["points=2", "points=40", "even=true", "period=0.5", "scale=0.3"])
def test_a_verdict_is_what_certifying_the_samples_gives(client, scene, solved, query):
    answer = client.get(f"/v1/plans/{solved['id']}/trajectory?{query}")
    assert answer.status_code == 200, answer.text
    motion = answer.json()
    verdicts = {proof["kind"]: proof for proof in motion["interpolations"]}
    for kind, proof in verdicts.items():
        again = given_back(client, scene, motion, kind)
        assert proof["proven"] == again["proven"]
        assert {check["name"] for check in proof["failed"]} == failed_in(again)
    table = client.get(f"/v1/plans/{solved['id']}/trajectory?{query}&format=csv")
    words = {True: "proven", False: "unproven"}
    told = ", ".join(f"{kind}={words[proof['proven']]}" for kind, proof in verdicts.items())
    assert table.headers["wayproof-interpolation"] == told
    if query in {"even=true", "points=2"}:
        assert not verdicts["quintic"]["proven"]


def test_samples_lie_evenly_if_that_is_asked_for(client, scene):
    goal = {"type": "configuration", "name": "ready"}
    request = {"scene": scene, "group": "arm", "goal": goal, "seed": 3}
    retime = {"sample_period": 0.02, "even_samples": True}
    search = {"allowed_planning_time": 20.0}
    job = client.post(
        "/v1/plans?wait=40", json={**request, "retime": retime, "search": search}
    ).json()
    motion = job["result"]["trajectory"]
    gaps = np.diff(motion["times"])
    np.testing.assert_allclose(gaps[:-1], 0.02)
    assert gaps[-1] <= 0.02 + 1e-12
    assert not all(proof["proven"] for proof in motion["interpolations"])
    again = client.get(f"/v1/plans/{job['id']}/trajectory").json()
    assert again == motion
    straight = {proof["kind"]: proof for proof in motion["interpolations"]}["linear"]
    assert {"acceleration", "velocity continuity"} <= set(straight["unchecked"])


def test_a_way_back_is_delivered_as_proven(client, solved):
    back = client.post(f"/v1/plans/{solved['id']}/reverse?wait=40").json()
    motion = back["result"]["trajectory"]
    assert all(proof["proven"] for proof in motion["interpolations"])
    again = client.get(f"/v1/plans/{back['id']}/trajectory").json()
    assert again == motion


def test_a_stop_is_delivered_as_proven(client, scene, solved):
    running = client.get(f"/v1/plans/{solved['id']}/trajectory?polynomial=true").json()
    body = {"scene": scene, "group": "arm", "trajectory": running, "time": 0.4}
    for more in ({}, {"along_path": True, "limit_jerk": False}):
        answer = client.post("/v1/trajectories/stop", json={**body, **more}).json()
        if answer["failure"] is None:
            proofs = {proof["kind"]: proof for proof in answer["trajectory"]["interpolations"]}
            assert proofs["linear"]["proven"]
            assert proofs["quintic"]["proven"], proofs["quintic"]
            break
    else:
        pytest.fail(f"no stop at all: {answer['failure']}")


@pytest.fixture(scope="module")
def motion(client, solved):
    """Samples of a plan without names."""
    given = client.get(f"/v1/plans/{solved['id']}/trajectory?scale=0.5").json()
    return {name: given[name] for name in ("times", "positions", "velocities", "accelerations")}


@pytest.fixture(scope="module")
def names(solved):
    return solved["result"]["trajectory"]["joint_names"]


def turned(motion, *rows):
    return {**motion, **{row: np.array(motion[row])[:, TURNED].tolist() for row in rows}}


def test_joint_names_alone_are_the_names_of_rates_too(client, scene, motion, names):
    other = turned(motion, "positions", "velocities", "accelerations")
    other["joint_names"] = [names[i] for i in TURNED]
    assert certified(client, scene, other) == certified(client, scene, motion)


def test_velocity_names_stand_for_rates_alone_beside_joint_names(client, scene, motion, names):
    other = turned(motion, "velocities", "accelerations")
    other |= {"joint_names": names, "velocity_names": [names[i] for i in TURNED]}
    assert certified(client, scene, other) == certified(client, scene, motion)


def test_velocity_names_in_another_order_need_joint_names(client, scene, motion, names):
    assert certified(client, scene, {**motion, "velocity_names": names})["certificate"]["proven"]
    other = {**motion, "velocity_names": [names[i] for i in TURNED]}
    problem = refused(client, scene, other)
    assert problem["code"] == "problem_invalid"
    assert "joint_names" in problem["detail"]


@pytest.mark.parametrize("field", ["joint_names", "velocity_names"])
def test_names_in_another_order_do_not_turn_a_polynomial(client, scene, solved, names, field):
    exact = client.get(f"/v1/plans/{solved['id']}/trajectory?polynomial=true").json()
    other = turned(exact, "positions", "velocities", "accelerations")
    other[field] = [names[i] for i in TURNED]
    other["polynomial"] = {**exact["polynomial"], "joint_names": None}
    problem = refused(client, scene, other)
    assert problem["code"] == "problem_invalid"
    assert field in problem["detail"]


def test_samples_are_read_as_asked(client, scene, motion):
    for kind in ("quintic", "cubic", "cubic_spline", "linear"):
        answer = certified(client, scene, {**motion, "interpolation": kind})
        assert answer["interpolation"] == kind
        checks = {check["name"] for check in answer["certificate"]["checks"]}
        assert ("acceleration" in checks) == (kind != "linear")
        assert ("acceleration" in answer["unchecked"]) == (kind == "linear")
    without = {name: motion[name] for name in ("times", "positions", "velocities")}
    problem = refused(client, scene, {**without, "interpolation": "quintic"})
    assert "accelerations" in problem["detail"]
    body = {"scene": scene, "group": "arm", "time": 0.4}
    body["trajectory"] = {**motion, "interpolation": "linear"}
    answer = client.post("/v1/trajectories/stop", json=body)
    assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
