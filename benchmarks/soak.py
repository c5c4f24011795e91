"""Executions in a row, steered, blocked and killed at random: what has to hold of each does.

`make soak`. Of one robot, or of two that move as one group. After each the execution has to have
exactly one end and a whole log, the scene has to know the robots where they were measured last, and
a model built by Drake alone finds no collision of the measured motion, looked at every 2 ms, with
the table, with the obstacle while it was in the scene, or of robots with each other. What does not
hold is told, with the seed, and the command ends with 1.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.service_load.host import Host
from benchmarks.soak_rounds.apart import ApartSoak, configurations_of_both, faults_of_both
from benchmarks.soak_rounds.cell import Cell
from benchmarks.soak_rounds.checks import faults, num_configurations
from benchmarks.soak_rounds.rounds import Soak

# Answers take longer than this only if something hangs [s].
_LIMIT = 120.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print, and return 1 if something did not hold."""
    options = parser().parse_args(arguments)
    console = Console(soft_wrap=True)
    seed = np.random.SeedSequence().entropy if options.seed is None else options.seed
    rng = np.random.default_rng(seed)
    if options.apart:
        return _both(options, console, rng, seed)
    cell, ends, found, looked_at = Cell(options.robots), Counter[str](), 0, 0
    with Host(_LIMIT) as host:
        soak = Soak(host, cell, options.robots, rng)
        for i in range(options.executions):
            made = soak.next_round()
            wrong = list(dict.fromkeys(faults(made, cell)))
            ends[_end_of(made.execution)] += 1
            found, looked_at = found + len(wrong), looked_at + num_configurations(made)
            if wrong or options.verbose:
                _tell(console, f"{i}: {made.execution['id']}: {made.done}", wrong)
    told = ", ".join(f"{count} {end}" for end, count in ends.most_common())
    console.print(
        f"{options.executions} executions of {options.robots} robots, seed {seed}: {told}; "
        f"{looked_at} configurations looked at; {found} faults"
    )
    return 1 if found else 0


def _both(
    options: argparse.Namespace, console: Console, rng: np.random.Generator, seed: object
) -> int:
    """Run executions of two robots at once, print, and return 1 if something did not hold."""
    cell, ends, found, looked_at, refused = Cell(2), Counter[str](), 0, 0, 0
    with Host(_LIMIT) as host:
        soak = ApartSoak(host, cell, rng)
        for i in range(options.executions // 2):
            rounds = soak.next_rounds()
            wrong = list(dict.fromkeys(faults_of_both(rounds, cell)))
            for made in rounds.lanes.values():
                ends[_end_of(made.execution)] += 1
            found, refused = found + len(wrong), refused + rounds.refusals
            looked_at += len(configurations_of_both(rounds)[0])
            if wrong or options.verbose:
                done = {robot: made.done for robot, made in rounds.lanes.items()}
                _tell(console, f"{i}: {done}", wrong)
    told = ", ".join(f"{count} {end}" for end, count in ends.most_common())
    console.print(
        f"{ends.total()} executions of two robots apart, seed {seed}: {told}; {refused} refused "
        f"beside the other; {looked_at} configurations looked at; {found} faults"
    )
    return 1 if found else 0


def _end_of(execution: Mapping[str, Any]) -> str:
    """Return the code of an execution's failure, else its state."""
    failure = execution["failure"]
    return execution["state"] if failure is None else failure["code"]


def _tell(console: Console, what: str, wrong: Sequence[str]) -> None:
    """Print what was done, and the first faults."""
    console.print(what, markup=False)
    for fault in wrong[:5]:
        console.print(f"   {fault}", markup=False)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    made = argparse.ArgumentParser(description=__doc__)
    made.add_argument("--executions", type=int, default=50)
    made.add_argument("--robots", type=int, choices=[1, 2], default=1)
    made.add_argument(
        "--apart", action="store_true", help="two robots, each by executions of its own, at once"
    )
    made.add_argument("--seed", type=int, help="of all that is random; else a fresh one")
    made.add_argument("--verbose", action="store_true", help="tell what was done in each round")
    return made


if __name__ == "__main__":
    sys.exit(main())
