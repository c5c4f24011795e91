"""The soak finds what does not hold, and executions that are left alone have nothing of that."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from benchmarks.soak import main
from benchmarks.soak_rounds.cell import Cell
from benchmarks.soak_rounds.checks import Presence, Round, faults, positions
from tests.profiles import only_campaign

HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
BEGAN = datetime(2026, 1, 1, tzinfo=UTC)
# The first joint turns by 0.5 rad in a second.
TURN = {
    "breaks": [0.0, 1.0],
    "bases": [HOME],
    "coefficients": [[[0.0] * 6, [0.5, 0.0, 0.0, 0.0, 0.0, 0.0]]],
}


@pytest.fixture(scope="module")
def cell() -> Cell:
    return Cell(1)


def carried_out(**changes: object) -> Round:
    """A motion of a second that is measured four times, with nothing wrong."""
    times = [0.0, 0.25, 0.5, 1.0]
    rows = positions(TURN, np.array(times))
    events = [("queued", 1, {})]
    for i, (time, row) in enumerate(zip(times, rows, strict=True)):
        at = (BEGAN + timedelta(seconds=time)).isoformat()
        status = {"at": at, "time": time, "motion": 0, "positions": row.tolist()}
        events.append(("status", i + 2, status))
    events.append(("finished", 9, {}))
    arm = dict(zip([f"{name}_joint" for name in NAMES], rows[-1].tolist(), strict=True))
    state = {"robots": [{"robot": "left", "status": "at_rest", "positions": arm}]}
    ended = {"state": "succeeded", "failure": None}
    made = Round(ended, events, state, {0: TURN})
    for name, value in changes.items():
        setattr(made, name, value)
    return made


def test_what_holds_has_no_faults(cell: Cell) -> None:
    assert list(faults(carried_out(), cell)) == []


def test_faults_of_the_end_and_of_the_state_are_found(cell: Cell) -> None:
    [one] = faults(carried_out(execution={"state": "executing", "failure": {}}), cell)
    assert one == "it is executing"
    events = carried_out().events
    assert "begin with queued" in "".join(faults(carried_out(events=events[:-1]), cell))
    assert "not in order" in "".join(faults(carried_out(events=[*events[:2], *events[1:]]), cell))
    moved = carried_out().state
    moved["robots"][0]["positions"]["elbow_joint"] += 1e-6
    assert "measured last" in "".join(faults(carried_out(state=moved), cell))


@pytest.mark.parametrize(("since", "until", "is_met"), [(-1, 2, True), (0.9, 2, False)])
def test_what_is_in_the_way_between_measurements_is_found_while_it_is_there(
    cell: Cell, since: float, until: float, *, is_met: bool
) -> None:
    # Where the hand is after 0.4 s, between two measurements; it is smaller than what lies between.
    turned = 0.2
    c, s = np.cos(turned), np.sin(turned)
    place = [0.492 * c - 0.133 * s, 0.492 * s + 0.133 * c, 0.45]
    there = [BEGAN + timedelta(seconds=seconds) for seconds in (since, until)]
    found = list(faults(carried_out(obstacles=[Presence(place, *there)]), cell))
    assert bool(found) == is_met
    assert all(each.startswith("collision: late") for each in found)


@pytest.mark.campaign
@only_campaign("a server starts and robots move: a minute")
@pytest.mark.parametrize("robots", [1, 2])
def test_executions_that_are_disturbed_hold(robots: int) -> None:
    assert main(["--executions", "6", "--robots", str(robots)]) == 0
