"""What the service costs and how much it takes: `wayproof serve`, asked over HTTP as users ask it.

Start of the server; what `?wait` takes besides the plan, one after another and at a steady rate;
how late events are; polls and plans a second, by locust; plans of several kinds a second, with what
processor time they take; plans beside a crowd of clients; durable jobs that do nothing; scenes of
many boxes, posted and edited, within a time limit; memory. What fails or does not end is told as
such, and the command ends with 1.
`docs/explanation/benchmarks.md` says more.
"""

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from rich.console import Console

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.service_load.answers import cancels, starts, waits
from benchmarks.service_load.boxes import boxes
from benchmarks.service_load.crowd import crowds
from benchmarks.service_load.host import Host
from benchmarks.service_load.loads import loads
from benchmarks.service_load.measure import Measure, table
from benchmarks.service_load.memory import memories
from benchmarks.service_load.noops import noops
from benchmarks.service_load.rate import rates
from benchmarks.service_load.throughput import throughput

type Section = Callable[[Host, argparse.Namespace], Iterator[Measure]]

SECTIONS: dict[str, Section] = {
    "start": lambda host, options: (
        step for workers in options.workers for step in starts(host, options.starts, workers)
    ),
    "wait": lambda host, options: waits(host, options.waits),
    "rate": lambda host, options: rates(host, options.rate, options.seconds),
    "events": lambda host, options: cancels(host, options.cancels),
    "load": lambda host, options: loads(host, options.users, options.seconds),
    "throughput": lambda host, options: throughput(host, options.workers, options.seconds),
    "crowd": lambda host, options: crowds(host, options.clients, options.period, options.seconds),
    "jobs": lambda _, options: iter([noops(options.noops, options.slots)]),
    "boxes": lambda host, options: boxes(host, options.boxes, options.limit),
    "memory": lambda host, options: memories(host, options.plans),
}
_QUICK = {
    "starts": 1,
    "workers": [1],
    "clients": 3,
    "period": 0.2,
    "plans": 2,
    "waits": 3,
    "cancels": 1,
    "users": 1,
    "seconds": 1,
    "noops": 10,
    "slots": 1,
    "boxes": [10],
    "limit": 30.0,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, and return 1 if something failed."""
    options = parser().parse_args(arguments)
    if options.quick:
        vars(options).update(_QUICK)
    measures = list(measured(options))
    if options.json:
        print(json.dumps([measure.plain() for measure in measures]))
    else:
        Console().print(table(measures))
    return 1 if any(measure.faults for measure in measures) else 0


def measured(options: argparse.Namespace) -> Iterator[Measure]:
    """Yield what is measured, section by section."""
    with Host(options.limit) as host:
        for name in options.only or SECTIONS:
            yield from SECTIONS[name](host, options)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    made = argparse.ArgumentParser(description=__doc__)
    made.add_argument("--starts", type=int, default=3)
    made.add_argument("--workers", type=int, nargs="*", default=[1, 2], help="of servers")
    made.add_argument("--rate", type=float, default=20.0, help="plans begun a second")
    made.add_argument("--clients", type=int, default=1000, help="that poll beside plans")
    made.add_argument("--period", type=float, default=5.0, help="of each client's polls [s]")
    made.add_argument("--plans", type=int, default=1000, help="between looks at the memory")
    made.add_argument("--waits", type=int, default=100, help="plans that are waited for")
    made.add_argument("--cancels", type=int, default=10, help="events that are waited for")
    made.add_argument("--users", type=int, default=8, help="of locust, at once")
    made.add_argument("--seconds", type=int, default=10, help="that each kind of user asks")
    made.add_argument("--noops", type=int, default=1000, help="jobs that do nothing")
    made.add_argument("--slots", type=int, default=2, help="processes that do nothing")
    made.add_argument("--boxes", type=int, nargs="*", default=[10, 100, 1000, 10_000])
    made.add_argument("--limit", type=float, default=60.0, help="seconds for an answer")
    made.add_argument("--only", choices=list(SECTIONS), nargs="+", help="these sections")
    made.add_argument("--quick", action="store_true", help="everything once, and small")
    made.add_argument("--json", action="store_true")
    return made


if __name__ == "__main__":
    sys.exit(main())
