"""What `?wait` costs besides the plan, when requests come at a steady rate whatever is answered."""

import asyncio
import time
from collections.abc import Iterator
from typing import Any

import httpx

from benchmarks.service_load.host import ARM, Host, arm_plan, reason
from benchmarks.service_load.measure import Measure

# Plans at once before anything is counted: every worker has loaded the scene by then.
_WARM_UP = 8


def rates(host: Host, per_second: float, seconds: float) -> Iterator[Measure]:
    """Ask for plans that are waited for; yield how long each takes, and how much is not the plan's.

    Args:
        host: Of the server.
        per_second: Requests begin so often, also if those before them are not answered [1/s].
        seconds: For so long [s].
    """
    host.need()
    request = arm_plan(host.post("/v1/scenes", ARM)["id"])
    yield from asyncio.run(_asked(host.url, request, per_second, seconds))


async def _asked(
    url: str, request: dict[str, Any], per_second: float, seconds: float
) -> tuple[Measure, Measure]:
    what = f"`?wait`, {per_second:g} a second"
    whole, over = Measure(f"{what}: a plan"), Measure(f"{what}: without the plan's own time")
    limits = httpx.Limits(max_connections=None, max_keepalive_connections=None)
    async with httpx.AsyncClient(base_url=url, timeout=60, limits=limits, trust_env=False) as http:

        async def plan(at: float, measures: tuple[Measure, Measure] | None) -> None:
            await asyncio.sleep(max(0.0, at - time.perf_counter()))
            try:
                answer = await http.post("/v1/plans?wait=60", json=request)
                took = time.perf_counter() - at
                answer.raise_for_status()
            except httpx.HTTPError as fault:
                whole.faults.append(reason(fault))
                return
            if measures is not None:
                measures[0].seconds.append(took)
                measures[1].seconds.append(took - own_seconds(answer.json()))

        now = time.perf_counter()
        await asyncio.gather(*(plan(now, None) for _ in range(_WARM_UP)))
        began = time.perf_counter()
        count = max(1, round(per_second * seconds))
        await asyncio.gather(*(plan(began + i / per_second, (whole, over)) for i in range(count)))
        whole.rate = whole.num_done / (time.perf_counter() - began)
    over.faults += whole.faults
    return whole, over


def own_seconds(job: dict[str, Any]) -> float:
    """Return what a plan itself took [s]."""
    timings: dict[str, float] = job["timings"]
    return sum(timings.get(part, 0.0) for part in ("load", "total", "samples"))
