"""What the server and its workers have in memory: at rest, and after many plans."""

import asyncio
from collections.abc import Iterator
from typing import Any

import httpx

from benchmarks.service_load.host import ARM, Host, arm_plan, reason
from benchmarks.service_load.measure import Measure
from benchmarks.serving.processes import resident

_AT_ONCE = 4


def memories(host: Host, plans: int) -> Iterator[Measure]:
    """Make plans; yield the memory before, half-way and after: it is to stay as it is.

    Args:
        host: Of the server; a new one is started.
        plans: How many.
    """
    server = host.start()
    server.be_ready()
    request = arm_plan(host.post("/v1/scenes", ARM)["id"])
    yield Measure("memory: at rest", mebibytes=resident(server.pid))
    for done, count in ((plans // 2, plans // 2), (plans, plans - plans // 2)):
        measure = Measure(f"memory: after {done:,} plans")
        asyncio.run(_made(host.url, request, count, measure))
        measure.mebibytes = resident(server.pid)
        yield measure


async def _made(url: str, request: dict[str, Any], count: int, measure: Measure) -> None:
    async with httpx.AsyncClient(base_url=url, timeout=60, trust_env=False) as http:
        left = iter(range(count))

        async def work() -> None:
            for _ in left:
                try:
                    (await http.post("/v1/plans?wait=60", json=request)).raise_for_status()
                except httpx.HTTPError as fault:
                    measure.faults.append(reason(fault))

        await asyncio.gather(*(work() for _ in range(_AT_ONCE)))
