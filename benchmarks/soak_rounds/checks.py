"""What has to hold of an execution once it has ended, whatever was done meanwhile."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.soak_rounds.cell import Cell

FINAL = {"succeeded", "canceled", "aborted"}
# Instants between two measurements at which the motion is looked at [s].
_PERIOD = 0.002


@dataclass
class Presence:
    """An obstacle that was in the scene: where [m], and from when to when (ISO 8601)."""

    place: list[float]
    since: datetime
    until: datetime | None = None


@dataclass
class Round:
    """An execution, and what was done to it.

    Attributes:
        execution: As the API shows it at the end.
        events: All of its events, as its stream has them: type, number and data.
        state: Of the scene, at the end.
        trajectories: Exact motions that it followed, by their number.
        obstacles: That were in its scene.
        done: What was done, in order.
    """

    execution: dict[str, Any]
    events: Sequence[tuple[str, int, dict[str, Any]]]
    state: dict[str, Any]
    trajectories: dict[int, dict[str, Any]]
    obstacles: list[Presence] = field(default_factory=list)
    done: list[str] = field(default_factory=list)


def faults(round_: Round, cell: Cell) -> Iterator[str]:
    """Yield what does not hold: its end, its events, the live state, and what it touched."""
    yield from of_the_end(round_)
    yield from _of_the_state(round_)
    yield from (f"collision: {each}" for each in _collisions(round_, cell))


def num_configurations(round_: Round) -> int:
    """Return at how many configurations a motion is looked at."""
    return len(motion_of(round_)[0])


def of_the_end(round_: Round) -> Iterator[str]:
    """Yield what does not hold of the end of an execution and of its events."""
    types = [kind for kind, _, _ in round_.events]
    numbers = [number for _, number, _ in round_.events]
    state = round_.execution["state"]
    if state not in FINAL:
        yield f"it is {state}"
    if types.count("finished") != 1 or types[-1] != "finished" or types[0] != "queued":
        yield f"its events begin with {types[0]} and end with {types[-1]}"
    if numbers != sorted(set(numbers)):
        yield "its events are not in order"
    if (state == "succeeded") != (round_.execution["failure"] is None):
        yield f"it is {state} with the failure {round_.execution['failure']}"


def _of_the_state(round_: Round) -> Iterator[str]:
    statuses = [data for kind, _, data in round_.events if kind == "status"]
    if not statuses:
        return
    measured = statuses[-1]["positions"]
    robots = sorted(round_.state["robots"], key=lambda robot: robot["robot"])
    arms = [_arm(robot["positions"]) for robot in robots]
    if np.abs(np.concatenate(arms) - measured).max() > 1e-9:
        yield "the live state is not what was measured last"
    if any(robot["status"] != "at_rest" for robot in robots):
        yield f"robots are {[robot['status'] for robot in robots]}"


def arm_at(robots: Sequence[dict[str, Any]], name: str) -> np.ndarray:
    """Return the positions of an arm in a live state [rad]."""
    return next(_arm(one["positions"]) for one in robots if one["robot"] == name)


def _arm(positions: dict[str, float]) -> np.ndarray:
    return np.array([positions[name] for name in _ORDER if name in positions])


def _collisions(round_: Round, cell: Cell) -> list[str]:
    rows, instants = motion_of(round_)
    return cell.touching(rows, [obstacle_at(round_.obstacles, at) for at in instants])


def obstacle_at(obstacles: Sequence[Presence], at: float) -> list[float] | None:
    """Return where the obstacle was at an instant [s], None while there was none."""
    for one in obstacles:
        until = np.inf if one.until is None else one.until.timestamp()
        if one.since.timestamp() <= at <= until:
            return one.place
    return None


def motion_of(round_: Round) -> tuple[list[np.ndarray], list[float]]:
    """Return the measured motion at most `_PERIOD` apart, and when it was there [s].

    Between two measurements the robot follows its motion from one place to the other; how far it is
    from there is interpolated between what was measured at both.
    """
    statuses = [data for kind, _, data in round_.events if kind == "status"]
    rows = [np.array(data["positions"]) for data in statuses[:1]]
    instants = [_seconds(data) for data in statuses[:1]]
    for before, after in pairwise(statuses):
        motion = round_.trajectories[after["motion"]]
        begin = before["time"]
        if before["motion"] != after["motion"]:
            begin = min(after["time"], begin) if after["time"] >= begin else 0.0
        count = max(2, int(np.ceil(abs(after["time"] - begin) / _PERIOD)) + 1)
        shares = np.linspace(0.0, 1.0, count)[1:, None]
        path = positions(motion, begin + (after["time"] - begin) * shares[:, 0])
        ends = positions(motion, np.array([begin, after["time"]]))
        errors = [
            np.array(each["positions"]) - end
            for each, end in zip((before, after), ends, strict=True)
        ]
        rows += list(path + (1 - shares) * errors[0] + shares * errors[1])
        from_, to = _seconds(before), _seconds(after)
        instants += list(from_ + (to - from_) * shares[:, 0])
    return rows, instants


def positions(motion: dict[str, Any], times: np.ndarray) -> np.ndarray:
    """Return q(t) of an exact motion of revolute joints, shape (m, nq)."""
    breaks, bases = np.array(motion["breaks"]), np.array(motion["bases"])
    coefficients = np.array(motion["coefficients"])
    piece = np.clip(np.searchsorted(breaks, times, side="right") - 1, 0, len(bases) - 1)
    local = (times - breaks[piece])[:, None]
    total = np.zeros((len(times), bases.shape[1]))
    for k in range(coefficients.shape[1] - 1, -1, -1):
        total = total * local + coefficients[piece, k]
    return bases[piece] + total


def _seconds(data: dict[str, Any]) -> float:
    return datetime.fromisoformat(data["at"]).timestamp()


_ORDER = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
