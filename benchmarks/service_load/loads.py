"""How many polls and plans a second there are, as locust measures them."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.service_load.host import ARM, Host, arm_plan
from benchmarks.service_load.measure import Measure

_USERS = Path(__file__).with_name("users.py")
_KINDS = {"Polls": "polls of a plan", "Plans": "plans of milliseconds, waited for"}
# For locust to start and to end, besides its run [s].
_MORE = 60.0


class NoLoad(Exception):
    """Locust gave no numbers; with what it printed last."""


def loads(host: Host, users: int, seconds: int) -> Iterator[Measure]:
    """Let users ask at once for a while; yield what they waited for, and how many there were.

    Args:
        host: Of the server.
        users: How many, of each kind in turns.
        seconds: How long each kind asks [s].

    Raises:
        NoLoad: There are no numbers.
    """
    host.need()
    request = arm_plan(host.post("/v1/scenes", ARM)["id"])
    plan = host.post("/v1/plans?wait=30", request)
    told_to_users = for_users(plan["id"], request, seconds)
    for kind, what in _KINDS.items():
        for number in sorted({1, users}):
            measure = Measure(f"{what}, {number} at once")
            [told] = run_locust(host.url, kind, number, seconds, told_to_users)
            yield read(measure, told)


def for_users(plan: str, request: dict[str, Any], seconds: int) -> dict[str, str]:
    """Return the variables that `users.py` reads."""
    return {
        "WAYPROOF_BENCH_SECONDS": str(seconds),
        "WAYPROOF_BENCH_PLAN": f"/v1/plans/{plan}",
        "WAYPROOF_BENCH_REQUEST": json.dumps(request),
    }


def read(measure: Measure, told: dict[str, Any]) -> Measure:
    """Return a measure with what locust tells of one kind of request.

    Args:
        measure: To be filled.
        told: An entry of its JSON; it rounds response times above 100 ms to two digits.
    """
    failed = int(told["num_failures"])
    measure.faults += ["refused, or no plan"] * failed
    for milliseconds, count in sorted(
        told["response_times"].items(), key=lambda one: float(one[0])
    ):
        measure.seconds += [1e-3 * float(milliseconds)] * int(count)
    span = told["last_request_timestamp"] - told["start_time"]
    measure.rate = (told["num_requests"] - failed) / span if span > 0 else 0.0
    return measure


def run_locust(
    url: str, kind: str, users: int, seconds: int, environment: dict[str, str]
) -> list[dict[str, Any]]:
    """Run locust and return its statistics."""
    command = [sys.executable, "-m", "locust", "-f", str(_USERS), kind, "--host", url]
    command += ["--headless", "--users", str(users), "--spawn-rate", str(users)]
    command += ["--run-time", f"{seconds + _MORE:.0f}s", "--json", "--only-summary"]
    done = subprocess.run(
        command,
        check=False,
        capture_output=True,
        text=True,
        timeout=seconds + 2 * _MORE,
        env={**os.environ, **environment},
    )
    # It ends with 1 if a request failed: that is counted, not raised.
    try:
        told: list[dict[str, Any]] = json.loads(done.stdout)
    except ValueError as fault:
        raise NoLoad(done.stderr[-1000:]) from fault
    if len(told) != 1:
        message = f"{kind}: {len(told)} kinds of requests; {done.stderr[-1000:]}"
        raise NoLoad(message)
    return told
