"""How many plans a second some workers make, and what processor time each plan takes, and where.

A plan here has one worker and one process: what more processors give follows from both processor
times, as long as there is one server (`docs/how-to/choose-a-machine.md`).
"""

import json
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from benchmarks.service_load.connection import Connection
from benchmarks.service_load.host import ARM, Host, arm_plan
from benchmarks.service_load.measure import Measure
from benchmarks.serving.processes import cpu_seconds, workers

_SCENES = Path(__file__).resolve().parents[2] / "scenes"
_TO_SHELF = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "upper"}]}
# Beyond its workers, how many plans are asked for at once, so that none is idle.
_MORE = 2


def throughput(host: Host, slots: Sequence[int], seconds: float) -> Iterator[Measure]:
    """Keep workers busy with plans of a kind for a while, for several kinds and numbers of workers.

    Args:
        host: Of the servers; a new one is started for each number.
        slots: Numbers of workers.
        seconds: For each kind [s].
    """
    for count in slots:
        chosen = {"WAYPROOF_PLAN_SLOTS": str(count), "WAYPROOF_SEARCH_PROCESSES": "1"}
        host.start(chosen).be_ready()
        for kind, request in _requests(host):
            yield from _busy(host, f"plans ({kind}), {count} workers", request, count, seconds)


def _requests(host: Host) -> Iterator[tuple[str, dict[str, Any]]]:
    yield "an arm, not refined", arm_plan(host.post("/v1/scenes", ARM)["id"])
    text = (_SCENES / "panda_shelf.scene.yaml").read_bytes()
    headers = {"content-type": "application/yaml"}
    shelf = host.http.post("/v1/scenes", content=text, headers=headers).raise_for_status().json()
    refined = {"scene": shelf["id"], "group": "panda", "goal": _TO_SHELF}
    yield "into a shelf, refined", refined
    yield "into a shelf, refined, jerk limited", refined | {"retime": {"method": "ruckig"}}


def _busy(
    host: Host, what: str, request: dict[str, Any], count: int, seconds: float
) -> Iterator[Measure]:
    plans, work, serving = (
        Measure(what),
        Measure(f"{what}: processor time of a worker, each"),
        Measure(f"{what}: processor time of the server, each"),
    )
    connections, seeds = threading.local(), iter(range(10**9))

    def plan() -> None:
        if not hasattr(connections, "own"):
            connections.own = Connection(host.url)
        body = json.dumps(request | {"seed": next(seeds)}).encode()
        began = time.perf_counter()
        answer = connections.own.post("/v1/plans?wait=60", body)
        if answer.fault is not None or answer.json()["state"] != "succeeded":
            plans.faults.append(answer.fault or "no plan")
        else:
            plans.seconds.append(time.perf_counter() - began)

    def plan_until(end: float) -> None:
        while time.perf_counter() < end:
            plan()

    at_once = count + _MORE
    with ThreadPoolExecutor(at_once) as threads:
        list(threads.map(lambda _: plan(), range(4 * at_once)))  # every worker has the scene
        plans.seconds.clear()
        own, below, began = cpu_seconds(host.pid), _of_workers(host.pid), time.perf_counter()
        list(threads.map(plan_until, [began + seconds] * at_once))
        took = time.perf_counter() - began
        done = max(1, plans.num_done)
        plans.rate = plans.num_done / took
        work.seconds = [(_of_workers(host.pid) - below) / done]
        serving.seconds = [(cpu_seconds(host.pid) - own) / done]
    yield from (plans, work, serving)


def _of_workers(server: int) -> float:
    """Return the processor time of a server's workers [s]."""
    return sum(process.cpu_seconds for process in workers(server))
