"""Where robots are: the latest revision's own state, and on top of it what was measured since."""

from datetime import UTC, datetime, timedelta

import pytest

from planning.domain.robot.joints import JointType
from service.executions.models import ExecutionState
from service.executions.requests import UrRtdeDriver
from service.executions.robot_status import status_after
from service.scenes.live import (
    DocumentSource,
    EditSource,
    ExecutionSource,
    KeptState,
    Motion,
    RobotStatus,
    by_joint,
    live_states,
)

MADE = datetime(2026, 1, 1, tzinfo=UTC)
LATER = MADE + timedelta(seconds=1)
DESCRIBED = {"a": {"j": 0.0, "k": 1.0}, "b": {"j": 2.0}}
REST, MOVING = RobotStatus.AT_REST, RobotStatus.MOVING


def kept(robot, positions, ended="exe_1", source=None):
    return KeptState(robot, positions, REST, source or ExecutionSource(ended), LATER, ended)


def motion(execution, *robots, sequence=1, positions=None):
    joints = {f"{robot}::j": JointType.REVOLUTE for robot in robots}
    return Motion(execution, robots[0], sequence, robots, joints, LATER, positions)


def states(known=(), motions=()):
    return live_states(DESCRIBED, (3, MADE), known, motions)


def test_what_was_measured_lies_over_what_is_described_joint_by_joint():
    found = states([kept("a", {"k": 5.0})])
    assert found["a"].positions == {"j": 0.0, "k": 5.0}
    assert (found["a"].source, found["a"].updated_at) == (ExecutionSource("exe_1"), LATER)
    assert found["b"].positions == {"j": 2.0}
    assert (found["b"].source, found["b"].updated_at) == (DocumentSource(3), MADE)


def test_what_was_set_by_hand_is_described():
    found = states([kept("b", {}, source=EditSource(2))])["b"]
    assert (found.positions, found.source) == ({"j": 2.0}, EditSource(2))


def test_what_moves_is_where_it_was_measured_last_and_what_waits_where_it_was():
    found = states(motions=[motion("exe_2", "a", positions={"a": {"j": 7.0}})])["a"]
    assert (found.positions, found.status) == ({"j": 7.0, "k": 1.0}, MOVING)
    assert (found.source, found.execution) == (ExecutionSource("exe_2"), "exe_2")
    waiting = states(motions=[motion("exe_2", "a")])["a"]
    assert (waiting.positions, waiting.status) == (DESCRIBED["a"], REST)
    assert (waiting.source, waiting.execution) == (DocumentSource(3), "exe_2")


def test_a_motion_may_be_of_several_robots():
    both = {"a": {"j": 7.0}, "b": {"j": 8.0}}
    found = states(motions=[motion("exe_2", "a", "b", positions=both)])
    assert [found[robot].positions["j"] for robot in "ab"] == [7.0, 8.0]
    assert [found[robot].execution for robot in "ab"] == ["exe_2", "exe_2"]


@pytest.mark.parametrize("source", [None, EditSource(3)])
def test_a_motion_that_has_ended_since_it_was_looked_for_tells_nothing(source):
    """What it left is known by then, and may have been replaced by hand."""
    stale = motion("exe_1", "a", positions={"a": {"j": 7.0}})
    found = states([kept("a", {"j": 9.0}, source=source)], [stale])["a"]
    assert (found.positions["j"], found.status, found.execution) == (9.0, REST, None)


def test_of_two_the_one_that_moves_is_named():
    first = motion("exe_2", "a", positions={"a": {"j": 7.0}})
    found = states(motions=[motion("exe_3", "a", sequence=2), first])["a"]
    assert (found.execution, found.source) == ("exe_2", ExecutionSource("exe_2"))


def test_coordinates_are_told_by_robot_and_joint():
    joints = {"a::j": JointType.REVOLUTE, "b::base": JointType.FLOATING, "b::k": JointType.PLANAR}
    q = [float(i) for i in range(11)]
    expected = {"a": {"j": 0.0}, "b": {"base": q[1:8], "k": q[8:]}}
    assert by_joint(joints, q) == expected
    v = q[:10]
    expected = {"a": {"j": 0.0}, "b": {"base": v[1:7], "k": v[7:]}}
    assert by_joint(joints, v, are_velocities=True) == expected


LOST = {"code": "driver_lost", "evidence": {"driver": "real", "rests": False}}
RESTS = {"code": "driver_lost", "evidence": {"driver": "real", "rests": True}}
REAL = UrRtdeDriver(type="ur_rtde", host="cell")
FAULT = {"code": "tracking_lost", "evidence": {}}


@pytest.mark.parametrize(
    ("driver", "last", "failure", "status"),
    [
        ("simulated", "executing", FAULT, "at_rest"),  # its process was killed
        (REAL, "executing", FAULT, "unknown"),
        (REAL, "canceled", None, "at_rest"),
        (REAL, "aborted", FAULT, "at_rest"),
        (REAL, "aborted", LOST, "unknown"),
        (REAL, "aborted", RESTS, "at_rest"),
        (REAL, "succeeded", None, "at_rest"),
    ],
)
def test_a_robot_is_known_to_rest_if_its_driver_says_so_or_cannot_move_it(
    driver, last, failure, status
):
    assert status_after(driver, ExecutionState(last), failure) == status
