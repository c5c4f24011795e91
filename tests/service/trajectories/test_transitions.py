"""Running motions, stopped and spliced over HTTP."""

import numpy as np
import pytest

SLOW = {"frame": "arm::tcp", "speed": 0.001}


def post(client, scene, what, **body):
    body = {"scene": scene, "group": "arm", "allowed_time": 60, **body}
    return client.post(f"/v1/trajectories/{what}", json=body)


@pytest.fixture(scope="module")
def running(client, scene, solved):
    """Return a motion as it is delivered, samples and polynomial, under jerk limits."""
    path = {"waypoints": solved["result"]["path"], "retime": {"method": "ruckig"}}
    return post(client, scene, "retime", **path, polynomial=True).json()["trajectory"]


def state_at(motion, time):
    """Return the rows of a delivered motion at one of its sampled instants."""
    row = motion["times"].index(time)
    return [motion[rates][row] for rates in ("positions", "velocities", "accelerations")]


def asked(client, scene, what, running, **body):
    """Return a motion from the middle of another one, which may be spliced onto itself."""
    time = running["times"][len(running["times"]) // 2]
    onto = {"onto": running} if what == "splice" else {}
    return time, post(client, scene, what, trajectory=running, time=time, **onto, **body)


@pytest.mark.parametrize("what", ["stop", "splice"])
def test_the_motion_goes_on_from_its_state_and_is_proven(client, scene, running, what):
    time, answer = asked(client, scene, what, running, polynomial=True)
    found = answer.json()
    assert (answer.status_code, found["failure"]) == (200, None)
    motion = found["trajectory"]
    # A first piece of some 1e-8 s is told as part of the second: its jerk changes that much.
    allowed = (1e-6, 1e-6, 1e-4)
    states = zip(state_at(motion, 0.0), state_at(running, time), allowed, strict=True)
    for got, was, tolerance in states:
        np.testing.assert_allclose(got, was, atol=tolerance)
    np.testing.assert_allclose(motion["velocities"][-1], 0, atol=1e-6)
    assert found["certificate"]["proven"]
    assert found["stage"]["intervals"] > 0
    assert found["interpolation"] == "polynomial"
    if what == "splice":
        assert found["onto_interpolation"] == "polynomial"
        np.testing.assert_allclose(motion["positions"][-1], running["positions"][-1], atol=1e-6)
    # What is delivered can be brought back: the polynomial is exact.
    exact = motion["polynomial"]["breaks"][-1]
    assert exact == motion["duration"] == motion["times"][-1]


@pytest.mark.parametrize("limit_jerk", [True, False])
def test_a_stop_along_the_path_is_as_proven(client, scene, running, limit_jerk):
    body = {"along_path": True, "limit_jerk": limit_jerk}
    time, answer = asked(client, scene, "stop", running, **body)
    found = answer.json()
    assert found["failure"] is None
    assert found["certificate"]["proven"]
    assert ("jerk" in {check["name"] for check in found["certificate"]["checks"]}) == limit_jerk
    motion = found["trajectory"]
    rates = 3 if limit_jerk else 2
    begun, was = state_at(motion, 0.0)[:rates], state_at(running, time)[:rates]
    for got, known in zip(begun, was, strict=True):
        np.testing.assert_allclose(got, known, atol=1e-5)
    # Its end lies between two samples of the path: each joint's between theirs.
    path = np.array(running["positions"])
    assert (path.min(axis=0) - 1e-9 <= motion["positions"][-1]).all()
    assert (path.max(axis=0) + 1e-9 >= motion["positions"][-1]).all()
    assert motion["duration"] <= running["duration"] - time + 1e-9


def test_jerk_is_limited_off_the_path(client, scene, running):
    _, answer = asked(client, scene, "stop", running, limit_jerk=False)
    assert answer.status_code == 422
    assert "along_path" in answer.json()["detail"]


@pytest.mark.parametrize("what", ["stop", "splice"])
def test_a_way_out_that_cannot_be_proven_is_a_failure_with_the_checks(client, scene, running, what):
    _, answer = asked(client, scene, what, running, tool_limits=[SLOW])
    failure = answer.json()["failure"]
    assert (answer.status_code, failure["code"]) == (200, "not_certified")
    assert answer.json()["trajectory"] is None
    assert "tool_speed arm::tcp" in {check["name"] for check in failure["evidence"]["checks"]}
    locked = [{"type": "locked_joints", "joints": ["arm::elbow_joint"]}]
    _, kept = asked(client, scene, what, running, path_constraints=locked)
    checks = kept.json()["failure"]["evidence"]["checks"]
    assert {check["name"] for check in checks} == {"constraint 0: locked_joints"}


@pytest.mark.parametrize("what", ["stop", "splice"])
def test_samples_are_delivered_as_asked_for(client, scene, running, what):
    _, answer = asked(client, scene, what, running, num_points=7)
    assert len(answer.json()["trajectory"]["times"]) == 7
    assert answer.json()["trajectory"]["polynomial"] is None
    _, refused = asked(client, scene, what, running, num_points=7, sample_period=0.01)
    assert (refused.status_code, refused.json()["code"]) == (422, "problem_invalid")
    assert "`sample_period` and `num_points`" in refused.json()["detail"]


def test_what_cannot_be_meant_is_refused(client, scene, running):
    late = running["duration"] + 0.01
    for what, extra in (("stop", {}), ("splice", {"onto": running})):
        for time, code in ((late, "problem_invalid"), (-0.1, "request_invalid")):
            answer = post(client, scene, what, trajectory=running, time=time, **extra)
            assert (answer.status_code, answer.json()["code"]) == (422, code)
            assert answer.json()["detail"].removeprefix("body.").startswith("time: ")
    backwards = {**running["polynomial"], "breaks": running["polynomial"]["breaks"][::-1]}
    for field in ("trajectory", "onto"):
        motions = {"trajectory": running, "onto": running}
        motions[field] = {**running, "polynomial": backwards}
        answer = post(client, scene, "splice", **motions, time=0.0)
        assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid")
        short = {**running, "polynomial": None, "times": running["times"][:-1]}
        answer = post(client, scene, "splice", **{**motions, field: short}, time=0.0)
        assert answer.json()["evidence"]["field"].startswith(f"{field}.")
    nobody = [{"type": "locked_joints", "joints": ["arm::nobody"]}]
    answer = post(client, scene, "stop", trajectory=running, time=0.0, path_constraints=nobody)
    assert (answer.status_code, answer.json()["code"]) == (422, "unknown_name")


@pytest.mark.parametrize(
    "along", [{}, {"along_path": True}, {"along_path": True, "limit_jerk": False}]
)
@pytest.mark.parametrize("huge", [1e2, 1e6])
def test_motions_beyond_all_limits_are_failures_too(client, scene, huge, along):
    wild = {"breaks": [0, 10], "bases": [[0] * 6], "coefficients": [[[huge] * 6] * 16]}
    samples = {"times": [0, 1], "positions": [[0] * 6] * 2, "polynomial": wild}
    for time in (0.0, 10.0):
        # From there a motion is found, which the certifier refuses; the rest ruckig refuses itself.
        is_timed = bool(along) or (huge < 1e3 and time == 0)
        answer = post(client, scene, "stop", trajectory=samples, time=time, **along)
        assert answer.status_code == 200
        expected = "not_certified" if is_timed else "retiming_failed"
        assert answer.json()["failure"]["code"] == expected


def test_a_stop_that_would_last_for_hours_is_a_failure(client, scene):
    """Ruckig computes none of more than two hours, and says so by a code without a name."""
    far, near = [1e5, -1.57, 1.57, -1.57, -1.57, 0], [0.3, -1.57, 1.57, -1.57, -1.57, 0]
    running = {"times": [0, 2], "positions": [far, near], "velocities": [[0] * 6] * 2}
    answer = post(client, scene, "stop", trajectory=running, time=1.0)
    assert answer.status_code == 200, answer.text
    failure = answer.json()["failure"]
    assert failure["code"] == "retiming_failed"
    assert "longer than ruckig computes" in failure["detail"]
