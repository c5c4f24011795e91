"""Others' figures on the same problems, beside those of a run of ours.

They were measured once, not in this run and not at the same load: `earlier.json` says how.
"""

import json
from pathlib import Path
from typing import Any

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from benchmarks.motion_bench_maker.runs import Runs
from benchmarks.motion_bench_maker.summary import Spread, of_goal
from benchmarks.motion_bench_maker.table import WIDTH, spread_cell

_FILE = Path(__file__).with_suffix(".json")
_COLUMNS = ("solved", "ms, median / mean / p95", "duration s, median", "length rad", "free")


def print_peers(done: Runs, robot: str, refine: str) -> None:
    """Print what others took for joint goals, if they were measured with this robot."""
    peers = json.loads(_FILE.read_text())
    if robot != peers["robot"]:
        return
    table = Table(
        title=f"beside others, joint goals ({peers['source']})",
        title_justify="left",
        box=SIMPLE,
        pad_edge=False,
    )
    table.add_column("")
    for column in _COLUMNS:
        table.add_column(column, justify="right")
    table.add_row(f"this run, refine {refine}", *_ours(done))
    for row in peers["rows"]:
        if any(row["name"].startswith(name.partition(" ")[0]) for name in done.others):
            continue  # its rows are of this run
        table.add_row(row["name"], *_theirs(row))
    Console(width=WIDTH, highlight=False).print(table)


def _ours(done: Runs) -> tuple[str, ...]:
    runs = of_goal(done.runs, "joint")
    solved = [run for run in runs if run.solved]
    duration = Spread.of([run.duration for run in solved])
    length = Spread.of([run.length for run in solved])
    if duration is None or length is None:
        return (f"0 of {len(runs)}",) + ("-",) * (len(_COLUMNS) - 1)
    return (
        f"{len(solved)} of {len(runs)}",
        spread_cell(Spread.of([run.total_ms for run in runs])),
        f"{duration.median:.2f}",
        f"{length.median:.2f}",
        f"{100 * sum(run.free for run in solved) / len(solved):.0f} %",
    )


def _theirs(row: dict[str, Any]) -> tuple[str, ...]:
    return (
        str(row["solved"]),
        " / ".join(str(number) for number in row["milliseconds"]),
        f"{row['duration_s']:.2f}",
        f"{row['length_rad']:.2f}",
        f"{row['free_percent']} %",
    )
