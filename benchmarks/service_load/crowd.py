"""Whether many clients that poll hurt the planning beside them."""

import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from datetime import UTC, datetime
from typing import Any

from benchmarks.service_load.host import ARM, Host, arm_plan, timed
from benchmarks.service_load.loads import for_users, read, run_locust
from benchmarks.service_load.measure import Measure

# Until all of them have connected [s].
_SETTLED = 2.0
# Connections besides those of the crowd.
_OTHERS = 100


def crowds(host: Host, clients: int, period: float, seconds: int) -> Iterator[Measure]:
    """Make plans one after another, alone and while clients poll; yield how long both take.

    Args:
        host: Of the server.
        clients: Each polls a plan that has ended, on a connection of its own.
        period: Of the polls of each [s].
        seconds: For so long [s].
    """
    most = {"WAYPROOF_MAX_CONNECTIONS": str(clients + _OTHERS)}
    host.start(most).be_ready()
    request = arm_plan(host.post("/v1/scenes", ARM)["id"])
    plan = host.post("/v1/plans?wait=60", request)["id"]
    alone = Measure("a plan, while none polls")
    until = time.perf_counter() + seconds
    while time.perf_counter() < until and not alone.faults:
        timed(alone, host, lambda: host.post("/v1/plans?wait=60", request))
    yield alone
    beside = Measure(f"a plan, while {clients:,} clients poll every {period:g} s")
    polls = Measure(f"a poll of {clients:,} clients, every {period:g} s")
    with ThreadPoolExecutor(1) as one:
        whole = round(_SETTLED + seconds)
        told_to_users = for_users(plan, request, whole)
        told_to_users["WAYPROOF_BENCH_PERIOD"] = str(period)
        crowd = one.submit(run_locust, host.url, "Crowd", clients, whole, told_to_users)
        made = list(_while(crowd, beside, host, request))
        [told] = crowd.result()
    from_, to = told["start_time"] + _SETTLED, told["last_request_timestamp"]
    beside.seconds = [took for at, took in made if from_ <= at <= to - took]
    yield beside
    yield read(polls, told)


def _while(
    crowd: Future[Any], measure: Measure, host: Host, request: dict[str, Any]
) -> Iterator[tuple[float, float]]:
    """Yield when each plan was asked for (seconds of the epoch), and how long it took [s]."""
    while not crowd.done() and not measure.faults:
        at = datetime.now(UTC).timestamp()
        if timed(measure, host, lambda: host.post("/v1/plans?wait=60", request)) is not None:
            yield at, measure.seconds[-1]
