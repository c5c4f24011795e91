"""Which motions could be quicker at all: problem by problem, beside what nothing beats."""

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from benchmarks.motion_bench_maker.runs import Run, Runs
from benchmarks.motion_bench_maker.table import GOALS, WIDTH

_COLUMNS = ("duration s", "bound s", "ratio", "improved")


def print_bounds(done: Runs) -> None:
    """Print a row per problem that was planned, with both kinds of goals side by side."""
    table = Table(
        title="problem by problem: duration, and the lower bound by the slowest joint alone",
        title_justify="left",
        box=SIMPLE,
        pad_edge=False,
    )
    table.add_column("set")
    table.add_column("number", justify="right")
    for goal in GOALS:
        for column in _COLUMNS:
            table.add_column(f"{goal}: {column}", justify="right")
    found = {(run.problem.set, run.problem.index, run.goal): run for run in done.runs}
    for name, index in sorted({key[:2] for key in found}):
        cells = [cell for goal in GOALS for cell in _cells(found.get((name, index, goal)))]
        table.add_row(name, str(index), *cells)
    Console(width=WIDTH, highlight=False).print(table)


def _cells(run: Run | None) -> tuple[str, ...]:
    if run is None or not run.solved:
        return ("-",) * len(_COLUMNS)
    ratio = f"{run.duration / run.lower_bound:.3f}" if run.lower_bound > 0 else "-"
    return (
        f"{run.duration:.3f}",
        f"{run.lower_bound:.3f}",
        ratio,
        "yes" if run.improved else "no",
    )
