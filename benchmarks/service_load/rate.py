"""What `?wait` costs besides the plan, when requests come at a steady rate whatever is answered."""

import json
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from benchmarks.service_load.connection import Answer, Connection
from benchmarks.service_load.host import ARM, Host, arm_plan
from benchmarks.service_load.measure import Measure

# Plans at once before anything is counted, and connections: every worker has loaded the scene then.
_WARM_UP = 8
# Never set: a clock to wait by.
_idle = threading.Event()


def rates(host: Host, per_second: float, seconds: float) -> Iterator[Measure]:
    """Ask for plans that are waited for; yield how long each takes, and how much is not the plan's.

    Args:
        host: Of the server.
        per_second: Requests begin so often, also if those before them are not answered [1/s].
        seconds: For so long [s].
    """
    host.need()
    request = arm_plan(host.post("/v1/scenes", ARM)["id"])
    yield from _asked(host.url, request, per_second, seconds)


def _asked(
    url: str, request: dict[str, Any], per_second: float, seconds: float
) -> tuple[Measure, Measure]:
    what = f"`?wait`, {per_second:g} a second"
    whole, over = Measure(f"{what}: a plan"), Measure(f"{what}: without the plan's own time")
    body = json.dumps(request).encode()
    connections = threading.local()

    def plan(at: float) -> tuple[float, Answer]:
        if not hasattr(connections, "own"):
            connections.own = Connection(url)
        _idle.wait(max(0.0, at - time.perf_counter()))
        answer = connections.own.post("/v1/plans?wait=60", body)
        return time.perf_counter() - at, answer

    with ThreadPoolExecutor(_WARM_UP) as threads:
        now = time.perf_counter()
        list(threads.map(plan, [now] * _WARM_UP))
        began = time.perf_counter()
        count = max(1, round(per_second * seconds))
        due = [began + i / per_second for i in range(count)]
        for took, answer in threads.map(plan, due):
            if answer.fault is not None:
                whole.faults.append(answer.fault)
                continue
            whole.seconds.append(took)
            over.seconds.append(took - own_seconds(answer.json()))
        whole.rate = whole.num_done / (time.perf_counter() - began)
    over.faults += whole.faults
    return whole, over


def own_seconds(job: dict[str, Any]) -> float:
    """Return what a plan itself took [s]."""
    timings: dict[str, float] = job["timings"]
    return sum(timings.get(part, 0.0) for part in ("load", "total", "samples"))
