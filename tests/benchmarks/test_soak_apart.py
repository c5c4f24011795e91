"""Two robots that are soaked apart: both measured motions are looked at together."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from benchmarks.soak_rounds.apart import ApartRounds, configurations_of_both, faults_of_both
from benchmarks.soak_rounds.cell import Cell
from benchmarks.soak_rounds.checks import Round, positions

NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
BEGAN = datetime(2026, 1, 1, tzinfo=UTC)
# Stretched out over the table towards each other, side by side: they meet where one turns inwards.
OUT = [0.75, -0.3, 0.3, 0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def cell() -> Cell:
    return Cell(2)


def turning(start: list[float], rate: float, after: float) -> tuple[Round, list[float]]:
    """A motion of a second about the first axis that begins some seconds later, and its end."""
    motion = {
        "breaks": [0.0, 1.0],
        "bases": [start],
        "coefficients": [[[0.0] * 6, [rate, 0.0, 0.0, 0.0, 0.0, 0.0]]],
    }
    times = [0.0, 0.25, 0.5, 1.0]
    rows = positions(motion, np.array(times))
    events = [("queued", 1, {})]
    for i, (time, row) in enumerate(zip(times, rows, strict=True)):
        at = (BEGAN + timedelta(seconds=after + time)).isoformat()
        status = {"at": at, "time": time, "motion": 0, "positions": row.tolist()}
        events.append(("status", i + 2, status))
    events.append(("finished", 9, {}))
    return Round({"state": "succeeded", "failure": None}, events, {}, {0: motion}), rows[-1]


def rounds(left: tuple[Round, list[float]], right: tuple[Round, list[float]]) -> ApartRounds:
    state = {
        "robots": [
            {
                "robot": name,
                "status": "at_rest",
                "positions": dict(zip([f"{n}_joint" for n in NAMES], end, strict=True)),
            }
            for name, (_, end) in (("left", left), ("right", right))
        ]
    }
    lanes = {"left": left[0], "right": right[0]}
    for made in lanes.values():
        made.state = state
    return ApartRounds(lanes, 0)


def test_robots_that_keep_apart_have_no_faults(cell: Cell) -> None:
    made = rounds(turning(OUT, 0.25, 0.0), turning(OUT, 0.25, 0.0))
    assert list(faults_of_both(made, cell)) == []
    assert len(configurations_of_both(made)[0]) >= 1 / 0.002


def test_what_one_does_where_the_other_one_is_by_then_is_found(cell: Cell) -> None:
    """The right one turns in, and rests there; the left one turns in a second later."""
    right = turning(OUT, -0.75, 0.0)
    met = rounds(turning(OUT, -0.75, 1.5), right)
    assert any("left::" in each and "right::" in each for each in faults_of_both(met, cell))
    # It stays out: one of both has the place to itself.
    assert list(faults_of_both(rounds(turning(OUT, 0.1, 1.5), right), cell)) == []


def test_the_live_state_of_each_is_looked_at(cell: Cell) -> None:
    made = rounds(turning(OUT, 0.25, 0.0), turning(OUT, 0.25, 0.0))
    made.lanes["left"].state["robots"][1]["positions"]["elbow_joint"] += 1e-6
    assert list(faults_of_both(made, cell)) == [
        "right: the live state is not what was measured last"
    ]
