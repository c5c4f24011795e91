"""How long a start takes, what waiting for a plan costs besides it, and how late events are."""

import json
import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import httpx

from benchmarks.service_load.connection import Connection
from benchmarks.service_load.host import ARM, Host, arm_plan, timed
from benchmarks.service_load.measure import Measure
from benchmarks.service_load.rate import own_seconds

_PLANS = "/v1/plans?wait=60"
_WALL = {"name": "wall", "shape": {"box": [0.02, 9, 0.2]}, "pose": {"position": [0, 0, 0]}}
_WALLED = {
    "name": "walled",
    "robots": [{"name": "body", "model": "planar_l", "positions": [-0.35, -0.3, 0]}],
    "objects": [_WALL],
}
# There is no way through the wall, which no planner knows.
_ENDLESS = {
    "group": "body",
    "goal": {"type": "joint", "positions": [0.3, -0.3, 0.0]},
    "search": {"allowed_planning_time": 600.0, "attempts": 100, "solve_time": 2.0},
}


def starts(host: Host, count: int, workers: int) -> Iterator[Measure]:
    """Start servers; yield how long each step takes, from the start of the process on.

    Args:
        host: Of the servers.
        count: How many.
        workers: That each of them plans with.
    """
    names = ("listens", "is ready", "has answered its first plan")
    steps = [Measure(f"start, {workers} workers: until it {name}") for name in names]
    for _ in range(count):
        began = time.perf_counter()
        server = host.start({"WAYPROOF_PLAN_SLOTS": str(workers)})
        steps[0].seconds.append(time.perf_counter() - began)
        server.be_ready()
        steps[1].seconds.append(time.perf_counter() - began)
        given = timed(Measure(""), host, lambda: _plan(host, _scene(host)))
        if given is None or given["state"] != "succeeded":
            steps[2].faults.append("no plan" if given is None else str(given["failure"]))
        else:
            steps[2].seconds.append(time.perf_counter() - began)
    yield from steps


def waits(host: Host, count: int) -> Iterator[Measure]:
    """Wait for plans, one after another; yield how long, and how much of it is not the plan's.

    Until the last byte of the answer is there, over one `Connection`.
    """
    host.need()
    whole, over = Measure("`?wait`: a plan"), Measure("`?wait`: without the plan's own time")
    request = json.dumps(arm_plan(_scene(host))).encode()
    with closing(Connection(host.url)) as connection:
        connection.post(_PLANS, request)  # loads the scene where plans are made
        for _ in range(count):
            began = time.perf_counter()
            answer = connection.post(_PLANS, request)
            took = time.perf_counter() - began
            if answer.fault is not None or answer.json()["state"] != "succeeded":
                whole.faults.append(answer.fault or "failed")
                continue
            whole.seconds.append(took)
            over.seconds.append(took - own_seconds(answer.json()))
    over.faults += whole.faults
    yield from (whole, over)


def cancels(host: Host, count: int) -> Iterator[Measure]:
    """Cancel plans that would never end; yield how long until the event of their end is there."""
    host.need()
    measure = Measure("events: from a cancel to the event `finished`")
    request = {"scene": host.post("/v1/scenes", _WALLED)["id"], **_ENDLESS}
    for _ in range(count):
        path = f"/v1/plans/{host.post('/v1/plans', request)['id']}"
        with host.http.stream("GET", f"{path}/events") as stream:
            told = _types(stream)
            while next(told, "stage") not in {"stage", "finished"}:
                pass
            timed(measure, host, lambda path=path, told=told: _end(host, path, told))
    yield measure


def _end(host: Host, path: str, told: Iterator[str]) -> None:
    host.post(f"{path}/cancel")
    while next(told, "finished") != "finished":
        pass


def _types(stream: httpx.Response) -> Iterator[str]:
    """Yield the types of a stream's events (WHATWG HTML, 9.2)."""
    for line in stream.iter_lines():
        if line.startswith("event: "):
            yield line.removeprefix("event: ")


def _scene(host: Host) -> str:
    identifier: str = host.post("/v1/scenes", ARM)["id"]
    return identifier


def _plan(host: Host, scene: str) -> dict[str, Any]:
    # As long as `?wait=` may be; the limit of an answer comes first.
    job: dict[str, Any] = host.post(_PLANS, arm_plan(scene))
    if job["state"] != "succeeded":
        raise httpx.HTTPError(f"{job['state']}: {json.dumps(job['failure'])[:60]}")
    return job
