"""Methods of refinement and loads side by side, on the same problems in the same run."""

from collections import Counter
from collections.abc import Sequence
from itertools import product

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from benchmarks.motion_bench_maker.loads import Load
from benchmarks.motion_bench_maker.runs import Method, Run, Runs, row_name
from benchmarks.motion_bench_maker.summary import Spread, of_goal, stage_times
from benchmarks.motion_bench_maker.table import GOALS, WIDTH, print_faults, spread_cell

_COUNTS = ("solved", "free", "improved")
_SPREADS = (
    "duration s",
    "/ bound",
    "accelerations rad^2/s^3",
    "torques N^2 m^2 s",
    "length rad",
    "stage ms",
    "plan ms",
)


def print_comparison(
    done: Runs, methods: Sequence[Method], head: str, loads: Sequence[Load] = ("none",)
) -> None:
    """Print a table per kind of goal, a row per method and load; and what failed, and why."""
    console = Console(width=WIDTH, highlight=False)
    console.print(head)
    for goal in GOALS:
        if not (runs := of_goal(done.runs, goal)):
            continue
        table = Table(
            title=f"{goal} goals: median / mean / p95 of the problems that every row solved",
            title_justify="left",
            box=SIMPLE,
            pad_edge=False,
        )
        table.add_column("refine")
        for column in (*_COUNTS, *_SPREADS):
            table.add_column(column, justify="right")
        rows = list(product(methods, loads))
        common = _solved_by_all(runs, len(rows))
        for method, load in rows:
            members = [run for run in runs if (run.method, run.load) == (method, load)]
            table.add_row(row_name(method, load), *_cells(members, common))
        console.print(table)
    _print_reasons(console, done, methods)
    print_faults(console, done)


def _solved_by_all(runs: Sequence[Run], num_rows: int) -> set[str]:
    """Return the names of the problems that were solved in all rows."""
    counts = Counter(run.problem.name for run in runs if run.solved)
    return {name for name, count in counts.items() if count == num_rows}


def _cells(runs: Sequence[Run], common: set[str]) -> tuple[str, ...]:
    solved = [run for run in runs if run.solved]
    counts = (
        f"{len(solved)} of {len(runs)}",
        str(sum(run.free for run in solved)),
        str(sum(run.improved for run in solved)),
    )
    both = [run for run in solved if run.problem.name in common]
    numbers = (
        [run.duration for run in both],
        [run.duration / run.lower_bound for run in both if run.lower_bound > 0],
        [run.smoothness for run in both],
        [run.energy for run in both],
        [run.length for run in both],
        stage_times(both, "refine"),
        [run.total_ms for run in both],
    )
    digits = (2, 3, 0, 0, 2, 0, 0)
    cells = zip(numbers, digits, strict=True)
    return (*counts, *(spread_cell(Spread.of(values), digit) for values, digit in cells))


def _print_reasons(console: Console, done: Runs, methods: Sequence[Method]) -> None:
    """Print how often a method gave each reason, instants left out."""
    for method in methods:
        reasons = Counter(
            run.reason.partition(" at path parameters")[0]
            for run in done.of_method(method).runs
            if run.reason and method != "none"
        )
        for reason, count in reasons.most_common():
            console.print(f"{method}: {count} times: {reason}")
