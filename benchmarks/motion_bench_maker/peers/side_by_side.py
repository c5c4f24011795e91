"""Rows of ours and of other planners, of the same problems in the same run."""

from collections.abc import Sequence
from typing import Any

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from benchmarks.motion_bench_maker.runs import GoalKind, Method, Run, Runs
from benchmarks.motion_bench_maker.summary import Spread, of_goal
from benchmarks.motion_bench_maker.table import GOALS, WIDTH, spread_cell

# What counts as within limits: setpoints are rounded, and a hundredth breaks no gear.
_WITHIN = 1.01
_COLUMNS = (
    "solved",
    "free",
    "within limits",
    "free and within",
    "worst rate / limit",
    "ms, median / mean / p95",
    "duration s",
    "/ bound",
    "length rad",
)


def print_side_by_side(done: Runs, methods: Sequence[Method]) -> None:
    """Print a table per kind of goal, if other planners were asked; and why they failed."""
    if not done.others:
        return
    console = Console(width=WIDTH, highlight=False)
    for goal in GOALS:
        title = f"{goal} goals, in turns in this run; failed plans count in ms"
        table = Table(title=title, title_justify="left", box=SIMPLE, pad_edge=False)
        table.add_column("")
        for column in _COLUMNS:
            table.add_column(column, justify="right")
        for method in methods:
            runs = of_goal(done.of_method(method).runs, goal)
            table.add_row(f"Wayproof, refine {method}", *row(runs))
        for name, runs in done.others.items():
            table.add_row(name, *row(of_goal(runs, goal)))
        console.print(table)
    for name, run in _failed(done):
        console.print(f"{name}: {run.problem.name}, {run.goal} goal, not solved: {run.detail}")


def row(runs: Sequence[Run]) -> tuple[str, ...]:
    """Return the cells of one planner's runs."""
    solved = [run for run in runs if run.solved]
    within = [run for run in solved if run.peak_rate <= _WITHIN]
    worst = max((run.peak_rate for run in solved), default=None)
    ratios = [run.duration / run.lower_bound for run in solved if run.lower_bound > 0]
    return (
        f"{len(solved)} of {len(runs)}",
        str(sum(run.free for run in solved)),
        str(len(within)),
        str(sum(run.free for run in within)),
        "-" if worst is None else f"{worst:.3f}",
        spread_cell(Spread.of([run.total_ms for run in runs])),
        spread_cell(Spread.of([run.duration for run in solved]), 2),
        spread_cell(Spread.of(ratios), 3),
        spread_cell(Spread.of([run.length for run in solved]), 2),
    )


def peer_documents(done: Runs) -> dict[str, dict[GoalKind, dict[str, Any]]]:
    """Return the table as JSON: by the peer's name and the kind of goal, cells by column."""
    return {
        name: {goal: dict(zip(_COLUMNS, row(of_goal(runs, goal)), strict=True)) for goal in GOALS}
        for name, runs in done.others.items()
    }


def _failed(done: Runs) -> list[tuple[str, Run]]:
    return [(name, run) for name, runs in done.others.items() for run in runs if run.failure]
