"""The tables that people read."""

from collections.abc import Sequence

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from benchmarks.motion_bench_maker.runs import GoalKind, Run, Runs, by_set, row_name
from benchmarks.motion_bench_maker.summary import (
    Spread,
    of_goal,
    ratio,
    stage_names,
    stage_times,
)

WIDTH = 200
GOALS: tuple[GoalKind, ...] = ("joint", "pose")


def print_tables(done: Runs, drake: Runs | None, head: str, drake_note: str) -> None:
    """Print times, motions, failures, and Drake alone."""
    console = Console(width=WIDTH, highlight=False)
    console.print(head)
    for goal in GOALS:
        runs = of_goal(done.runs, goal)
        console.print(_times(runs, f"{goal} goals: milliseconds, median / mean / p95"))
        console.print(_motions(done, runs, f"{goal} goals: motions"))
    if load := Spread.of(done.load_ms):
        console.print(f"loading a world, counted nowhere above: {spread_cell(load, 0)} ms")
    if reload := Spread.of(done.reload_ms):
        console.print(f"where the world before is there: {spread_cell(reload, 0)} ms")
    print_faults(console, done)
    console.print(drake_note)
    if drake is None:
        return
    for goal in GOALS:
        runs = of_goal(drake.runs, goal)
        console.print(_times(runs, f"{goal} goals, Drake only: milliseconds"))
        if (times := ratio(done, drake, goal)) is not None:
            solved, free = sum(r.solved for r in runs), sum(r.free for r in runs)
            console.print(
                f"{goal} goals: Drake only takes {times:.1f} times as long (medians over the same "
                f"{len(runs)} problems); it solved {solved}, free {free}"
            )


def _times(runs: Sequence[Run], title: str) -> Table:
    stages = stage_names(runs)
    table = Table(title=title, title_justify="left", box=SIMPLE, pad_edge=False)
    table.add_column("set")
    for column in (*stages, "total", "cpu"):
        table.add_column(column, justify="right")
    for name, members in (*by_set(runs), ("all", runs)):
        cells = [spread_cell(Spread.of(stage_times(members, stage))) for stage in stages]
        total = spread_cell(Spread.of([run.total_ms for run in members]))
        cpu = spread_cell(Spread.of([run.cpu_ms for run in members]))
        table.add_row(name, *cells, total, cpu)
    return table


def _motions(done: Runs, runs: Sequence[Run], title: str) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE, pad_edge=False)
    table.add_column("set")
    columns = (
        "problems",
        "valid",
        "solved",
        "free",
        "length rad",
        "duration s",
        "bound s",
        "accelerations rad^2/s^3",
        "torques N^2 m^2 s",
        "improved",
    )
    for column in columns:
        table.add_column(column, justify="right")
    names = list(dict.fromkeys(problem.set for problem in done.problems))
    for name in (*names, "all"):
        members = [run for run in runs if name in ("all", run.problem.set)]
        solved = [run for run in members if run.solved]
        problems = sum(name in ("all", problem.set) for problem in done.problems)
        counts = (problems, len(members), len(solved), sum(run.free for run in solved))
        length = spread_cell(Spread.of([run.length for run in solved]), 2)
        duration = spread_cell(Spread.of([run.duration for run in solved]), 2)
        bound = spread_cell(Spread.of([run.lower_bound for run in solved]), 2)
        smoothness = spread_cell(Spread.of([run.smoothness for run in solved]))
        energy = spread_cell(Spread.of([run.energy for run in solved]))
        improved = str(sum(run.improved for run in solved))
        cells = (*map(str, counts), length, duration, bound, smoothness, energy, improved)
        table.add_row(name, *cells)
    return table


def print_faults(console: Console, done: Runs) -> None:
    """Print the problems that are not valid, were not solved, or whose motion is not free."""
    if done.invalid:
        names = ", ".join(problem.name for problem in done.invalid)
        console.print(f"not valid (start or goal collides): {names}")
    for run in done.runs:
        row = row_name(run.method, run.load)
        if run.failure:
            console.print(
                f"not solved: {run.problem.name}, {run.goal} goal, refine {row}: "
                f"{run.failure} "
                f"after {run.total_ms:.0f} ms: {run.detail}"
            )
        elif not run.free:
            console.print(f"NOT FREE: {run.problem.name}, {run.goal} goal, refine {row}")


def spread_cell(spread: Spread | None, digits: int = 1) -> str:
    """Return a spread in few signs: decimals only where they matter."""
    if spread is None:
        return "-"
    numbers = (spread.median, spread.mean, spread.p95)
    return " / ".join(f"{x:.{0 if x >= 100 else digits}f}" for x in numbers)
