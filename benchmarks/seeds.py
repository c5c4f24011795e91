"""Success and seconds over random seeds of each seed scene: `benchmarks/seeds.py --help`.

Every scene is loaded once; a run plans in it with a random seed of its own and within the time that
the seed allows. Seconds are those of all runs, failed ones included; a first plan, which imports
engines, is not counted. `--json` prints `{scene: {runs, solved, proven, seconds: {median, max}}}`.
The exit status is 1 if any run was not proven.
"""

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import planning  # noqa: E402
from benchmarks.seed_scenes.seeds import SEEDS, Seed  # noqa: E402
from planning.errors import PlanningFailure  # noqa: E402


@dataclass
class Row:
    """The runs of one seed."""

    seed: Seed
    seconds: list[float] = field(default_factory=list)
    solved: int = 0
    proven: int = 0
    failures: list[str] = field(default_factory=list)

    @property
    def wire(self) -> dict[str, object]:
        """The row for machines."""
        seconds = {"median": statistics.median(self.seconds), "max": max(self.seconds)}
        runs = len(self.seconds)
        return {"runs": runs, "solved": self.solved, "proven": self.proven, "seconds": seconds}


def main(
    arguments: Sequence[str] | None = None,
    clock: Callable[[], float] = time.monotonic,
    seeds: Sequence[Seed] = SEEDS,
) -> int:
    """Run, print and return the exit status.

    Args:
        arguments: Of the command line.
        clock: Monotonic seconds: by it runs are timed, and have the time that they are allowed.
        seeds: What there is to run.
    """
    options = _parser([seed.name for seed in seeds]).parse_args(arguments)
    _warm_up(clock)
    rows = [_measure(seed, options.runs, clock) for seed in seeds if seed.name in options.only]
    if options.json:
        print(json.dumps({row.seed.name: row.wire for row in rows}))
    else:
        Console().print(_table(rows))
    for row in rows:
        for failure in row.failures:
            print(f"{row.seed.name}: {failure}", file=sys.stderr)
    return int(any(row.proven < len(row.seconds) for row in rows))


def _parser(names: list[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=_positive, default=20, help="random seeds of each scene")
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="SCENE")
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    return parser


def _positive(word: str) -> int:
    number = int(word)
    if number < 1:
        message = f"at least 1, not {number}"
        raise argparse.ArgumentTypeError(message)
    return number


def _warm_up(clock: Callable[[], float]) -> None:
    """Plan something, so that every engine is imported."""
    problem = planning.PlanningProblem("arm", planning.ConfigurationGoal("ready"))
    deadline = planning.Deadline.after(60.0, clock)
    planning.plan(problem, _load("ur5e_pickup"), deadline=deadline)


def _load(scene: str) -> planning.World:
    path = planning.bundled_folder("scenes") / f"{scene}.scene.yaml"
    return planning.load_world(planning.read_scene(path))


def _measure(seed: Seed, runs: int, clock: Callable[[], float]) -> Row:
    world = _load(seed.scene)
    row = Row(seed)
    for number in range(runs):
        began = clock()
        deadline = planning.Deadline.after(seed.allowed, clock)
        try:
            legs = seed.run(world, number, deadline)
        except PlanningFailure as failure:
            row.failures.append(f"seed {number}: {failure.code}: {failure}")
        else:
            row.solved += 1
            row.proven += all(leg.plan.certificate.proven for leg in legs)
        row.seconds.append(clock() - began)
    return row


def _table(rows: list[Row]) -> Table:
    table = Table(title="seed scenes")
    table.add_column("scene")
    for column in ("runs", "solved", "proven", "median s", "max s", "allowed s"):
        table.add_column(column, justify="right")
    for row in rows:
        counts = [str(len(row.seconds)), str(row.solved), str(row.proven)]
        seconds = [f"{statistics.median(row.seconds):.2f}", f"{max(row.seconds):.2f}"]
        table.add_row(row.seed.name, *counts, *seconds, f"{row.seed.allowed:.0f}")
    return table


if __name__ == "__main__":
    sys.exit(main())
