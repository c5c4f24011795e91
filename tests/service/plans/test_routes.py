"""Plans over HTTP: asked for, waited for, polled, streamed, stopped."""

import numpy as np
import pytest

from service.client.events import decode_events
from tests.service.pages import walk

READY = {"type": "configuration", "name": "ready"}


@pytest.fixture
def request_of(scene):
    def build(**fields):
        search = {"allowed_planning_time": 60.0}
        return {"scene": scene, "group": "arm", "goal": READY, "search": search, **fields}

    return build


def events_of(client, path, **headers):
    with client.stream("GET", path, headers=headers) as answer:
        assert answer.status_code == 200
        assert answer.headers["content-type"].startswith("text/event-stream")
        return list(decode_events(answer))


def test_a_finished_plan_says_everything(client, solved):
    result = solved["result"]
    assert solved["progress"] == 1.0
    assert solved["seed"] == 3
    assert solved["digest"] == result["digest"]
    assert {"python", "drake", "ompl", "toppra", "ruckig", "wayproof"} <= set(solved["versions"])
    assert {"load", "goals", "search", "retime", "certify"} <= set(solved["timings"])
    assert solved["created_at"] <= solved["started_at"] <= solved["finished_at"]
    certificate = result["certificate"]
    assert certificate["proven"]
    assert certificate["min_clearance"] > 0
    assert all(check["passed"] for check in certificate["checks"])
    names = {check["name"] for check in certificate["checks"]}
    assert {"position", "velocity", "acceleration", "clearance", "start", "goal"} <= names
    assert set(result["stages"]) == {"goals", "search", "refine", "retime", "certify"}


def test_the_motion_goes_from_start_to_goal_at_rest(client, scene, solved):
    group = client.get(f"/v1/scenes/{scene}").json()["groups"][0]
    result = solved["result"]
    motion = result["trajectory"]
    np.testing.assert_allclose(motion["positions"][0], group["configurations"]["home"], atol=1e-6)
    np.testing.assert_allclose(motion["positions"][-1], group["configurations"]["ready"], atol=1e-6)
    np.testing.assert_allclose(motion["positions"][-1], result["goal_configuration"], atol=1e-9)
    np.testing.assert_allclose([motion["velocities"][0], motion["velocities"][-1]], 0, atol=1e-6)
    assert motion["times"][-1] == motion["duration"]
    assert motion["joint_names"] == group["position_names"]


def test_the_same_seed_gives_the_same_digest(client, request_of, solved):
    request = request_of(seed=3)
    again = client.post("/v1/plans?wait=60", json=request).json()
    assert again["id"] != solved["id"]
    assert again["digest"] == solved["digest"]
    assert again["result"] == solved["result"]


def test_a_plan_is_accepted_and_says_where_to_poll(client, request_of):
    answer = client.post("/v1/plans", json=request_of())
    assert answer.status_code == 202
    path = answer.headers["location"]
    assert path == f"/v1/plans/{answer.json()['id']}"
    types = [event.type for event in events_of(client, f"{path}/events")]
    assert types[:2] == ["queued", "started"]
    assert types[-1] == "finished"
    assert client.get(path).json()["state"] == "succeeded"


@pytest.mark.parametrize("prefer", ["wait=60", "respond-async, wait=60", 'wait="40"'])
def test_a_preference_to_wait_is_honoured(client, request_of, prefer):
    answer = client.post("/v1/plans", json=request_of(), headers={"Prefer": prefer})
    assert answer.status_code == 200
    assert answer.json()["state"] == "succeeded"


def test_events_are_numbered_and_replayed(client, solved):
    path = f"/v1/plans/{solved['id']}/events"
    events = events_of(client, path)
    ids = [int(event.id) for event in events]
    assert ids == sorted(set(ids))
    stages = [event.data["stage"] for event in events if event.type == "stage"]
    assert stages[:3] == ["load", "goals", "search"]
    progress = [event.data["progress"] for event in events if event.type in {"stage", "progress"}]
    assert progress == sorted(progress)
    middle = len(events) // 2
    assert events_of(client, path, **{"Last-Event-ID": events[middle].id}) == events[middle + 1 :]
    assert events_of(client, path, **{"Last-Event-ID": "not ours"}) == events


def test_pages_of_plans_join_up_and_filter(client, scene, solved):
    whole = walk(client, "/v1/plans", limit=200)
    assert "result" not in whole[0]
    assert [job["id"] for job in walk(client, "/v1/plans", limit=3)] == [job["id"] for job in whole]
    of_scene = client.get(f"/v1/plans?scene={scene}&state=succeeded&limit=200").json()["items"]
    assert solved["id"] in {item["id"] for item in of_scene}
    assert {item["state"] for item in of_scene} == {"succeeded"}
    assert client.get("/v1/plans?scene=nothing").json() == {"items": [], "next": None}


def test_a_plan_says_which_revision_it_is_for(client, scene, solved):
    latest = client.get(f"/v1/scenes/{scene}").json()["revision"]
    assert solved["request"]["revision"] == latest


def test_cancel_is_harmless_after_the_end(client, solved):
    for _ in range(2):
        answer = client.post(f"/v1/plans/{solved['id']}/cancel")
        assert answer.status_code == 200
        assert answer.json()["state"] == "succeeded"


def test_unknown_plans_are_not_found(client):
    for path in ("", "/events", "/trajectory", "/replay.html"):
        answer = client.get(f"/v1/plans/pln_nothing{path}")
        assert answer.status_code == 404
        assert answer.json()["code"] == "not_found"
    assert client.post("/v1/plans/pln_nothing/cancel").status_code == 404


def test_a_start_in_collision_fails_with_pairs_and_depths(client, request_of):
    answer = client.post("/v1/plans?wait=60", json=request_of(start=[0.0] * 6))
    assert answer.status_code == 200
    job = answer.json()
    assert job["state"] == "failed"
    assert job["result"] is None
    assert job["failure"]["code"] == "start_in_collision"
    assert job["failure"]["stage"] == "goals"
    assert all(pair["depth"] > 0 for pair in job["failure"]["evidence"]["pairs"])
    assert client.get(f"/v1/plans/{job['id']}/trajectory").status_code == 409


def test_a_start_outside_limits_fails_with_the_joint(client, scene, request_of):
    group = client.get(f"/v1/scenes/{scene}").json()["groups"][0]
    start = [*group["configurations"]["home"]]
    start[2] = group["limits"]["upper"][2] + 0.1
    failure = client.post("/v1/plans?wait=60", json=request_of(start=start)).json()["failure"]
    assert failure["code"] == "start_out_of_limits"
    assert "elbow" in failure["detail"]


def test_a_configuration_in_collision_fails_with_the_nearest(client, request_of):
    leaning = [0.0] * 6
    request = request_of(goal={"type": "joint", "positions": [leaning]})
    failure = client.post("/v1/plans?wait=60", json=request).json()["failure"]
    assert failure["code"] == "goal_in_collision"
    nearest, relaxation = failure["evidence"]["nearest"], failure["evidence"]["relaxation"]
    assert nearest["binding"] == "collision"
    away = np.array(list(nearest["differences"].values()))
    np.testing.assert_allclose(np.array(leaning) + away, nearest["positions"], atol=1e-12)
    assert nearest["distance"] == pytest.approx(np.linalg.norm(away))
    told = {body for pair in relaxation["obstacles"] for body in pair["bodies"]}
    assert relaxation["remove"]
    assert set(relaxation["remove"]) <= told


def test_an_unreachable_pose_fails_with_the_nearest(client, request_of):
    goal = {"type": "pose", "poses": [{"position": [5, 0, 0]}]}
    request = request_of(goal=goal, ik={"max_trials": 20})
    failure = client.post("/v1/plans?wait=60", json=request).json()["failure"]
    assert failure["code"] == "goal_unreachable"
    assert failure["evidence"]["nearest"]["translation_error"] > 3
    assert failure["evidence"]["funnel"]["tried"] == 20


def test_a_pose_is_approached_in_a_straight_line(client, scene):
    pose = {"position": [0, 0, 0], "rpy": [3.141592653589793, 0, 0], "frame": "above"}
    goal = {"type": "pose", "poses": [pose], "approach": [0, 0, -0.08], "retreat": [0, 0, -0.05]}
    search = {"allowed_planning_time": 60.0, "approach_states": 25}
    request = {"scene": scene, "group": "arm", "goal": goal, "search": search, "seed": 2}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    parts = job["result"]["parts"]
    assert [part["kind"] for part in parts] == ["free", "approach", "retreat"]
    assert parts[1]["num_waypoints"] == 25
    assert parts[1]["length"] == pytest.approx(0.08)
    checks = {check["name"]: check for check in job["result"]["certificate"]["checks"]}
    assert checks["line"]["passed"]
    funnel = job["result"]["stages"]["goals"]["funnel"]
    assert funnel["approach_ok"] >= 1
    assert funnel["summary"].startswith(f"{funnel['tried']} tried")
    shares = sum(entry["share"] for entry in funnel["rejected"])
    assert shares + funnel["distinct"] / funnel["tried"] == pytest.approx(1)


def test_a_way_straight_up_is_a_plan(client, request_of):
    goal = {"type": "line", "displacement": {"vector": [0, 0, 0.05]}}
    job = client.post("/v1/plans?wait=60", json=request_of(goal=goal)).json()
    assert job["state"] == "succeeded", job["failure"]
    (part,) = job["result"]["parts"]
    assert (part["kind"], part["length"]) == ("line", pytest.approx(0.05))


def test_a_blocked_line_is_a_failure_with_its_evidence(client, request_of):
    goal = {"type": "line", "pose": {"position": [0, 0, 0], "frame": "block"}}
    job = client.post("/v1/plans?wait=60", json=request_of(goal=goal)).json()
    assert job["state"] == "failed"
    failure = job["failure"]
    assert (failure["code"], failure["stage"]) == ("line_blocked", "goals")
    assert 0 < failure["evidence"]["fraction"] < 1
    assert failure["evidence"]["stopped_by"]["reason"] == "collision"
    assert "block" in failure["evidence"]["stopped_by"]["pair"]["bodies"]


def test_a_plan_backwards_is_a_plan(client, solved):
    answer = client.post(f"/v1/plans/{solved['id']}/reverse?wait=60")
    assert answer.status_code == 200, answer.text
    back = answer.json()
    assert answer.headers["location"] == f"/v1/plans/{back['id']}"
    assert back["id"] != solved["id"]
    assert back["state"] == "succeeded"
    there, result = solved["result"], back["result"]
    assert result["certificate"]["proven"]
    motion = result["trajectory"]
    assert motion["duration"] == there["trajectory"]["duration"]
    np.testing.assert_allclose(motion["positions"][0], there["trajectory"]["positions"][-1])
    np.testing.assert_allclose(motion["positions"][-1], there["trajectory"]["positions"][0])
    assert back["request"]["start"] == there["trajectory"]["positions"][-1]
    assert back["request"]["goal"]["positions"] == there["trajectory"]["positions"][0]
    assert result["path"] == there["path"][::-1]
    assert client.get(f"/v1/plans/{back['id']}/trajectory").json() == motion
    assert back["id"] in {job["id"] for job in client.get("/v1/plans").json()["items"]}
    again = client.post(f"/v1/plans/{back['id']}/reverse?wait=60").json()
    np.testing.assert_allclose(
        again["result"]["trajectory"]["positions"], there["trajectory"]["positions"], atol=1e-9
    )


def test_there_is_no_way_back_from_nowhere(client, request_of):
    assert client.post("/v1/plans/pln_nobody/reverse").status_code == 404
    goal = {"type": "joint", "positions": [9.0] * 6}
    failed = client.post("/v1/plans?wait=60", json=request_of(goal=goal)).json()
    answer = client.post(f"/v1/plans/{failed['id']}/reverse")
    assert answer.status_code == 409
    assert answer.json()["code"] == "no_trajectory"


def test_a_plan_that_is_late_says_where_it_was_and_what_it_spent(client, request_of):
    request = request_of(search={"allowed_planning_time": 1e-6})
    job = client.post("/v1/plans?wait=60", json=request).json()
    failure = job["failure"]
    assert (job["state"], failure["code"]) == ("failed", "deadline_exceeded")
    assert failure["evidence"]["allowed"] == 1e-6
    assert {"load", failure["stage"], "total"} <= set(failure["timings"])
    assert job["timings"] == failure["timings"]
    assert client.get(f"/v1/plans/{job['id']}").json()["timings"] == failure["timings"]


def test_a_plan_that_nothing_cut_says_so(solved):
    assert solved["result"]["cut_short"] == []


def test_a_plan_says_what_the_clock_cut(client, request_of):
    """No shortcut takes less than a picosecond."""
    goal = {"type": "joint", "positions": [[0.4, -0.5, 0.9, -1.7, -1.4, 2.0]]}
    search = {"allowed_planning_time": 60.0, "shortcut_time": 1e-12, "num_states": 300}
    search |= {"interpolate_time": 1e-12}
    job = client.post("/v1/plans?wait=60", json=request_of(goal=goal, search=search)).json()
    assert job["state"] == "succeeded", job["failure"]
    assert "interpolate" in job["result"]["cut_short"]
    assert set(job["result"]["cut_short"]) <= set(job["timings"])
