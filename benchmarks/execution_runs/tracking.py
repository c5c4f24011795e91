"""How far robots are from where they should be, and how late their controllers, scene by scene."""

from collections.abc import Iterator
from typing import Any

import httpx

from benchmarks.execution_runs.executions import QUERIES, begun, ended, planned, posted
from benchmarks.execution_runs.rows import Row
from benchmarks.service_load.host import Host, reason


def trackings(host: Host, scenes: int) -> Iterator[Row]:
    """Carry out a plan in each bundled scene by the simulated driver, at full speed.

    Args:
        host: Of the server.
        scenes: How many of them.
    """
    for name, group, wanted in QUERIES[:scenes]:
        row = Row(f"{name}: {group} to {next(iter(wanted.values()))}")
        try:
            _carry_out(host, row, planned(host, posted(host, name), group, wanted))
        except httpx.HTTPError as fault:
            row.faults.append(reason(fault))
        yield row


def _carry_out(host: Host, row: Row, plan: dict[str, Any]) -> None:
    if plan["state"] != "succeeded":
        row.faults.append(f"no plan: {plan['failure']['code']}")
        return
    done = ended(host, begun(host, plan))
    if done["state"] != "succeeded":
        row.faults.append(f"{done['state']}: {done['failure']['code']}")
    status = done["status"] or {}
    row.numbers["motion s"] = plan["result"]["trajectory"]["duration"]
    if "max_tracking_error" in status:
        row.numbers["error mrad or mm"] = 1e3 * status["max_tracking_error"]
        row.note_jitter(status["jitter"])
    if status.get("contacts"):
        row.faults.append(f"{len(status['contacts'])} contacts")
