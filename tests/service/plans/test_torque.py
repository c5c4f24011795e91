"""Torque limits, payloads and masses over HTTP."""

import pytest

PAYLOAD = {"frame": "arm::tool0", "mass": 6.0, "center_of_mass": [0, 0, 0.1]}


def post(client, scene, what, **body):
    body = {"scene": scene, "group": "arm", "allowed_time": 60, **body}
    return client.post(f"/v1/trajectories/{what}", json=body)


def torque(certificate):
    return next((c for c in certificate["checks"] if c["name"] == "torque"), None)


def test_a_plan_a_path_and_a_trajectory_are_proven_to_keep_torques(client, scene, solved):
    retime = {"effort": True, "payload": PAYLOAD}
    request = {"scene": scene, "group": "arm", "seed": 3, "retime": retime}
    request["search"] = {"allowed_planning_time": 60.0}
    request["goal"] = {"type": "configuration", "name": "ready"}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    check = torque(job["result"]["certificate"])
    assert check["passed"]
    assert 0 < check["value"] <= 1
    assert job["result"]["stages"]["retime"]["utilisation"]["torque"] <= 1
    assert job["request"]["retime"]["payload"]["mass"] == 6.0
    assert torque(solved["result"]["certificate"]) is None
    path = job["result"]["path"]
    timed = post(client, scene, "retime", waypoints=path, retime=retime, polynomial=True).json()
    assert torque(timed["certificate"])["passed"]
    motion = timed["trajectory"]
    asked = {"trajectory": motion, "effort": True}
    light, heavy = (
        torque(post(client, scene, "certify", **asked, payload=load).json()["certificate"])
        for load in (None, {**PAYLOAD, "mass": 60.0})
    )
    assert light["value"] < check["value"]
    assert not heavy["passed"]
    assert heavy["where"].startswith("arm::")
    charts = [
        client.get(f"/v1/plans/{entry['id']}/plots/torque.svg").text for entry in (job, solved)
    ]
    assert all("<svg" in chart for chart in charts)
    assert charts[0] != charts[1]


def test_what_is_too_heavy_is_a_failure_with_the_joint(client, scene, solved):
    retime = {"effort": True, "payload": {**PAYLOAD, "mass": 100.0}}
    answer = post(client, scene, "retime", waypoints=solved["result"]["path"], retime=retime).json()
    assert answer["failure"]["code"] == "retiming_failed"
    assert answer["failure"]["evidence"]["where"].startswith("arm::")


BAD = {
    "no mass": ({"mass": 0}, 422),
    "no body": ({"inertia": [1, 1, 3, 0, 0, 0]}, 422),
    "an unknown field": ({"weight": 3}, 422),
    "an unknown frame": ({"frame": "arm::hook"}, 422),
    "a frame that does not move": ({"frame": "arm::base_link"}, 422),
}


@pytest.mark.parametrize("name", BAD)
def test_a_payload_that_cannot_be_is_refused(client, scene, solved, name):
    changes, status = BAD[name]
    retime = {"payload": {**PAYLOAD, **changes}}
    path = solved["result"]["path"]
    answer = post(client, scene, "retime", waypoints=path, retime=retime)
    assert answer.status_code == status, answer.text
    motion = solved["result"]["trajectory"]
    answer = post(client, scene, "certify", trajectory=motion, payload=retime["payload"])
    assert answer.status_code == status, answer.text
    request = {"scene": scene, "group": "arm", "retime": retime}
    request["goal"] = {"type": "configuration", "name": "ready"}
    answer = client.post("/v1/plans?wait=60", json=request)
    if name == "a frame that does not move":
        assert answer.json()["failure"]["code"] == "problem_invalid"
    else:
        assert answer.status_code == status


def test_the_field_at_fault_is_named_as_the_request_has_it(client, scene, solved):
    path, motion = solved["result"]["path"], solved["result"]["trajectory"]
    still = {**PAYLOAD, "frame": "arm::base_link"}
    timed = post(client, scene, "retime", waypoints=path, retime={"payload": still}).json()
    assert timed["evidence"]["field"] == "retime.payload.frame"
    assert timed["detail"].startswith("retime.payload.frame: ")
    proven = post(client, scene, "certify", trajectory=motion, payload=still).json()
    assert proven["evidence"]["field"] == "payload.frame"
    assert proven["detail"].startswith("payload.frame: ")
    odd = {**PAYLOAD, "inertia": [1, 1, 3, 0, 0, 0]}
    timed = post(client, scene, "retime", waypoints=path, retime={"payload": odd}).json()
    assert timed["detail"].startswith("body.retime.payload: inertia: ")
    assert timed["detail"].count("payload") == 1


def test_a_mass_in_a_scene_is_kept_through_edits(client):
    thing = {"name": "can", "shape": {"cylinder": {"radius": 0.03, "length": 0.1}}, "mass": 0.5}
    thing |= {"movable": True, "pose": {"position": [0.5, 0.3, 0.2]}}
    scene = {"robots": [{"name": "arm", "model": "ur5e", "positions": "home"}], "objects": [thing]}
    posted = client.post("/v1/scenes", json=scene).json()
    operations = [{"op": "attach", "object": "can", "frame": "arm::tool0"}]
    client.patch(f"/v1/scenes/{posted['id']}", json={"operations": operations})
    document = client.get(f"/v1/scenes/{posted['id']}").json()["document"]
    assert document["objects"][0]["mass"] == 0.5
    assert document["objects"][0]["attached"]
