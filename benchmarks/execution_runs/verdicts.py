"""How long an edit takes to be answered while a robot moves in its scene."""

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import httpx

from benchmarks.execution_runs.executions import QUERIES, begun, ended, planned, posted
from benchmarks.execution_runs.rows import Row
from benchmarks.service_load.host import Host, reason
from benchmarks.serving.processes import cpu_seconds, descendants
from benchmarks.serving.server import pause

# What the project asks for [s].
ASKED = 0.1
# Slow enough to be moving still when the last edit is answered [s of the motion per second].
_SPEED = 0.005
# For how long the processor time of an execution alone is looked at [s].
_ALONE = 1.0


def verdicts(host: Host, count: int) -> Iterator[Row]:
    """Move a box `count` times: while nothing moves, out of the way, and into the way and out.

    Args:
        host: Of the server.
        count: How often, each.
    """
    for name, group, wanted in QUERIES[:2]:
        rest, free, blocked = (
            Row(f"{name}: {what}") for what in ("nothing moves", "unaffected", "conflict")
        )
        try:
            _measure(host, (name, group, wanted), count, (rest, free, blocked))
        except httpx.HTTPError as fault:
            blocked.faults.append(reason(fault))
        yield from (rest, free, blocked)


def _measure(
    host: Host, query: tuple[str, str, dict[str, str]], count: int, rows: tuple[Row, Row, Row]
) -> None:
    rest, free, blocked = rows
    name, group, wanted = query
    scene = posted(host, name)
    plan = planned(host, scene, group, wanted)
    if plan["state"] != "succeeded":
        rest.faults.append(f"no plan: {plan['failure']['code']}")
        return
    tool = _last_place(host, scene, group, plan)
    _patch(host, scene, {"op": "add", "object": _box(_place(0))})
    _note(host, rest, 0.0, _edits(host, scene, count, _place))
    execution = begun(host, plan, speed=_SPEED, on_conflict="ignore")
    before = _processor_seconds(host)
    pause(_ALONE)
    alone = (_processor_seconds(host) - before) / _ALONE
    _note(host, free, alone, _edits(host, scene, count, _place, ("unaffected", free)))

    def into_the_way(turn: int) -> list[float]:
        return [tool[0], tool[1], tool[2] + 0.001 * turn]

    wanted_verdict = ("conflict", blocked)
    _note(host, blocked, alone, _edits(host, scene, count, into_the_way, wanted_verdict))
    host.post(f"/v1/executions/{execution}/cancel")
    ended(host, execution)


def _edits(
    host: Host,
    scene: str,
    count: int,
    place: Callable[[int], list[float]],
    expected: tuple[str, Row] | None = None,
) -> Iterator[float]:
    """Move the box and yield how long each answer took [s]; another verdict is a fault."""
    for turn in range(count):
        pose = {"position": place(turn + 1)}
        began = time.perf_counter()
        answer = _patch(host, scene, {"op": "move", "object": "late", "pose": pose})
        yield time.perf_counter() - began
        given = [one["verdict"] for one in answer["executions"]]
        if expected is not None and given != [expected[0]]:
            expected[1].faults.append(f"{given} instead of {expected[0]}")


def _note(host: Host, row: Row, alone: float, edits: Iterator[float]) -> None:
    """Note how long edits take, and their processor time: a busy machine has others beside them.

    Args:
        host: Of the server.
        row: For the numbers.
        alone: Processor seconds a second of the execution without edits.
        edits: Yield the seconds of each.
    """
    began, processor = time.perf_counter(), _processor_seconds(host)
    seconds = list(edits)
    processor = _processor_seconds(host) - processor
    row.note_times(seconds)
    own = processor - alone * (time.perf_counter() - began)
    row.numbers["processor ms"] = 1e3 * max(0.0, own) / len(seconds)
    slow = [each for each in seconds if each > ASKED]
    if slow and row.what.rpartition(": ")[2] != "nothing moves":
        row.faults.append(f"{len(slow)} of {len(seconds)} took more than {1e3 * ASKED:.0f} ms")


def _processor_seconds(host: Host) -> float:
    """Return the processor time of the server and what it has started [s]."""
    total = 0.0
    for pid in (host.pid, *(process.pid for process, _ in descendants(host.pid))):
        with suppress(OSError):
            total += cpu_seconds(pid)
    return total


def _patch(host: Host, scene: str, operation: dict[str, Any]) -> dict[str, Any]:
    answer = host.http.patch(f"/v1/scenes/{scene}", json={"operations": [operation]})
    answer.raise_for_status()
    told: dict[str, Any] = answer.json()
    return told


def _box(position: list[float]) -> dict[str, Any]:
    shape = {"box": [0.06, 0.06, 0.06]}
    return {"name": "late", "shape": shape, "pose": {"position": position}}


def _place(turn: int) -> list[float]:
    """Return a place that no robot of the bundled scenes reaches."""
    return [3.0, 3.0, 0.5 + 0.01 * turn]


def _last_place(host: Host, scene: str, group: str, plan: dict[str, Any]) -> list[float]:
    """Return where the tool is at the end of a plan [m]."""
    rows = plan["result"]["trajectory"]["positions"]
    asked = {"group": group, "configurations": [rows[-1]]}
    [found] = host.post(f"/v1/scenes/{scene}/fk", asked)["results"]
    frames = [frame for name, frame in found.items() if name.startswith(f"{group}::")]
    position: list[float] = frames[-1]["position"]
    return position
