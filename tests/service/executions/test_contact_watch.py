"""Robots that different executions move are looked at together, by what is measured of them."""

import numpy as np
import pytest

from planning.execute.kinematic_driver import KinematicDriver
from tests.service.executions.crossing import begun, ended, execute, planned, posted, status

# Both go along x, 2 cm beside each other: a body is 140 mm wide.
SIDE_BY_SIDE = {
    "name": "side_by_side",
    "robots": [
        {"name": "a", "model": "planar_l", "positions": [-0.4, 0.0, 0.0]},
        {"name": "b", "model": "planar_l", "positions": [-0.4, 0.16, 0.0]},
    ],
}
GOALS = {"a": [0.4, 0.0, 0.0], "b": [0.4, 0.16, 0.0]}
# Less than what counts as lost, and more than the gap between both [m].
OFF = 0.06


@pytest.fixture
def scene(client):
    return posted(client, SIDE_BY_SIDE)


def both_moving(client, scene):
    """Executions of both robots, slow enough to be under way for long."""
    plans = [planned(client, scene, robot, goal) for robot, goal in GOALS.items()]
    found = []
    for plan in plans:
        answer = execute(client, plan=plan, speed=0.02)
        assert answer.status_code == 202, answer.text
        found.append(answer.json()["id"])
        begun(client, found[-1])
    return found


def test_both_executions_end_where_their_robots_touch(client, scene, monkeypatch):
    executions = both_moving(client, scene)
    read = KinematicDriver.read

    def pushed(driver, at):
        measured = read(driver, at)
        if measured.q[1] < 0.08:  # the first robot, which is pushed towards the other one
            measured = type(measured)(measured.time, measured.q + np.array([0, OFF, 0]), measured.v)
        return measured

    monkeypatch.setattr(KinematicDriver, "read", pushed)
    first, second = (ended(client, execution) for execution in executions)
    for one, other in ((first, second), (second, first)):
        assert (one["state"], one["failure"]["code"]) == ("aborted", "contact")
        evidence = one["failure"]["evidence"]
        assert sorted(evidence["pair"]) == ["a::body", "b::body"]
        assert evidence["execution"] == other["id"]
        assert evidence["depth"] == pytest.approx(OFF - 0.02, abs=2e-3)
        # It held where it was.
        rest = np.array(one["status"]["positions"])
        assert -0.4 < rest[0] < 0.4


def test_robots_that_keep_apart_are_left_alone(client, scene):
    executions = both_moving(client, scene)
    while min(status(client, execution)["time"] for execution in executions) < 0.02:
        pass
    for execution in executions:
        client.post(f"/v1/executions/{execution}/speed", json={"speed": 100})
    assert [ended(client, execution)["state"] for execution in executions] == ["succeeded"] * 2
