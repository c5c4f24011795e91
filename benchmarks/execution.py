"""Executions over HTTP: tracking error and jitter, edits while a robot moves, and readers.

`make bench-execution`. A section is a table: a plan in each bundled scene carried out by the
simulated driver; how long a `PATCH` of the scene takes to be answered with a verdict while a robot
moves; the jitter of one execution while others read its events. What fails is told in the last
column, and the command ends with 1. `docs/explanation/benchmarks.md` says more.
"""

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from rich.console import Console

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.execution_runs.readers import readers
from benchmarks.execution_runs.rows import Row, table_of
from benchmarks.execution_runs.tracking import trackings
from benchmarks.execution_runs.verdicts import verdicts
from benchmarks.service_load.host import Host

type Section = Callable[[Host, argparse.Namespace], Iterator[Row]]

SECTIONS: dict[str, tuple[str, Section]] = {
    "tracking": (
        "a plan of each scene, carried out at full speed",
        lambda host, options: trackings(host, options.scenes),
    ),
    "verdicts": (
        "an edit until it is answered, with its verdict",
        lambda host, options: verdicts(host, options.edits),
    ),
    "readers": (
        "readers of one execution's events",
        lambda host, options: readers(host, options.readers),
    ),
}
_QUICK = {"scenes": 1, "edits": 2, "readers": [0, 3]}
# Answers take longer than this only if something hangs [s].
_LIMIT = 120.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, and return 1 if something failed."""
    options = parser().parse_args(arguments)
    if options.quick:
        vars(options).update(_QUICK)
    found: dict[str, list[Row]] = {}
    with Host(_LIMIT) as host:
        host.need()
        for name in options.only or SECTIONS:
            found[name] = list(SECTIONS[name][1](host, options))
            if not options.json:
                Console().print(table_of(SECTIONS[name][0], found[name]))
    if options.json:
        print(json.dumps({name: [row.plain() for row in rows] for name, rows in found.items()}))
    return 1 if any(row.faults for rows in found.values() for row in rows) else 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    made = argparse.ArgumentParser(description=__doc__)
    made.add_argument("--scenes", type=int, default=7, help="how many of the bundled ones")
    made.add_argument("--edits", type=int, default=10, help="of each kind")
    made.add_argument("--readers", type=int, nargs="*", default=[0, 20, 200, 0])
    made.add_argument("--only", choices=list(SECTIONS), nargs="+", help="these sections")
    made.add_argument("--quick", action="store_true", help="everything once, and small")
    made.add_argument("--json", action="store_true")
    return made


if __name__ == "__main__":
    sys.exit(main())
