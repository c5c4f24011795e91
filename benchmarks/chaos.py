"""Chaos: plans and executions while workers, servers, disk and database fail.

`wayproof serve` runs as a user runs it. Clients ask it for plans of many kinds and move robots to
and fro; meanwhile workers are killed and stopped, the server is killed and ended and started again
on its data folder, the disk is full, the database is locked, and PostgreSQL is away. Several
servers may work on one PostgreSQL database, and clients talk to any of them. After each round a
checker looks at every job, every event and every row. `docs/explanation/benchmarks.md` says what
must hold.
Prints a table and every violation, and ends with 1 if there is one.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.chaos_rounds.rounds import Round, site

_DATABASES = ("sqlite", "postgresql")
_ENGINES = ("process", "ray")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print, and return 1 if something did not hold."""
    options = parser().parse_args(arguments)
    if options.quick:
        options.jobs, options.rounds = 10, 1
    console = Console()
    rounds: list[Round] = []
    for database in _DATABASES if options.database == "both" else (options.database,):
        rounds += _on(database, options, console)
    if options.json:
        print(json.dumps([_plain(one) for one in rounds]))
    else:
        console.print(table(rounds, options.seed))
    return 1 if any(one.violations for one in rounds) else 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    made = argparse.ArgumentParser(description=__doc__)
    made.add_argument("--database", choices=[*_DATABASES, "both"], default="both")
    made.add_argument("--engine", choices=_ENGINES, default="process")
    made.add_argument("--servers", type=int, default=1, help="on PostgreSQL; SQLite has one")
    made.add_argument("--jobs", type=int, default=200, help="on each database, about")
    made.add_argument("--rounds", type=int, default=4)
    made.add_argument("--seed", type=int, default=0)
    made.add_argument("--quick", action="store_true", help="one round of ten jobs")
    made.add_argument("--log", type=Path, help="a file for all that the servers print")
    made.add_argument("--json", action="store_true")
    return made


def table(rounds: Iterable[Round], seed: int) -> Table:
    """Return what happened, a line a round."""
    made = Table(title=f"seed {seed}")
    for head in ("round", "jobs", "s", "faults", "outcomes", "answers to repeat", "violations"):
        made.add_column(head, justify="right" if head in {"jobs", "s", "violations"} else "left")
    for one in rounds:
        again = {name: n for name, n in one.answers.items() if not name.startswith("2")}
        faults = {
            **one.faults,
            "start refused": one.refused,
            "stood down": one.stood_down,
        }
        cells = [one.name, str(one.jobs), f"{one.seconds:.0f}"]
        cells += [_counts(counts) for counts in (faults, one.outcomes, again)]
        made.add_row(*cells, str(len(one.violations)))
    return made


def _on(database: str, options: argparse.Namespace, console: Console) -> Iterable[Round]:
    num_servers = options.servers if database == "postgresql" else 1
    with site(database, options.engine, num_servers) as made:
        if not (made.database.disk.is_real or options.json):
            what = "SQLite's files are limited instead, PostgreSQL's cannot be"
            console.print(f"no small file system may be mounted here: {what}")
        for number in range(1, options.rounds + 1):
            one = made.round(number, options.jobs // options.rounds, options.seed)
            if not options.json:
                print(f"{one.name}: {one.jobs} jobs, {len(one.violations)} violations")
                for violation in one.violations:
                    print(f"{one.name}: {violation}", flush=True)
            yield one
        if options.log is not None:
            with options.log.open("ab") as log:
                log.write(made.printed())


def _counts(counts: dict[str, int]) -> str:
    return "\n".join(f"{count} {name}" for name, count in sorted(counts.items()) if count)


def _plain(one: Round) -> dict[str, object]:
    violations = [{"rule": v.rule, "job": v.job, "what": v.what} for v in one.violations]
    counters = {"faults": one.faults, "outcomes": one.outcomes, "answers": one.answers}
    plain = {name: dict(Counter(counter)) for name, counter in counters.items()}
    names = ("name", "jobs", "seconds", "refused", "stood_down")
    head = {name: getattr(one, name) for name in names}
    return {**head, **plain, "violations": violations}


if __name__ == "__main__":
    sys.exit(main())
