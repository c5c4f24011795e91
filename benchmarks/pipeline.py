"""Milliseconds per stage on the bundled scenes: `make bench`, or `benchmarks/pipeline.py --help`.

Every query is planned with several seeds in one process; the table has medians. A query that ends
without a motion is counted as failed, and its time is not hidden: it is in the total.
"""

import argparse
import json
import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from rich.console import Console
from rich.table import Table

import planning
from planning.domain.goals.goal import PoseGoal, PoseTarget
from planning.domain.request.options import RefineOptions, RetimeOptions, SearchOptions
from planning.errors import PlanningFailure

STAGES = ("goals", "setup", "search", "refine", "retime", "certify", "total")
QUERIES = (
    ("ur5e_pickup", "arm", "pick"),
    ("ur5e_pickup", "arm", "place"),
    ("panda_shelf", "panda", "upper"),
    ("panda_shelf", "panda", "lower"),
    ("maze_2d", "body", "exit"),
    ("window_3d", "body", "beyond"),
)


@dataclass
class Row:
    """The runs of one query."""

    query: str
    milliseconds: dict[str, list[float]] = field(default_factory=lambda: {s: [] for s in STAGES})
    durations: list[float] = field(default_factory=list)
    clearances: list[float] = field(default_factory=list)
    failed: int = 0


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--refine", choices=["none", "trajopt", "auto"], default="trajopt")
    parser.add_argument("--retime", choices=["toppra", "ruckig"], default="toppra")
    parser.add_argument("--allowed", type=float, default=10.0, help="seconds per plan")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = list(_measure(options))
    if options.json:
        print(json.dumps([row.__dict__ for row in rows]))
    else:
        Console().print(_table(rows, options))


def _measure(options: argparse.Namespace) -> Iterator[Row]:
    exact = np.zeros(3)
    for scene, group, frame in QUERIES:
        path = planning.bundled_folder("scenes") / f"{scene}.scene.yaml"
        world = planning.load_world(planning.read_scene(path))
        row = Row(f"{scene} to {frame}")
        for seed in range(options.seeds):
            goal = PoseGoal((PoseTarget(planning.Pose.identity(), frame),), "", exact, exact)
            problem = planning.PlanningProblem(
                group,
                goal,
                search=SearchOptions(allowed_planning_time=options.allowed),
                refine=RefineOptions(options.refine),
                retime=RetimeOptions(options.retime),
                seed=seed,
            )
            _run(world, problem, options.allowed, row)
        yield row


def _run(
    world: planning.World, problem: planning.PlanningProblem, allowed: float, row: Row
) -> None:
    began = time.perf_counter()
    deadline = planning.Deadline.after(allowed, time.monotonic)
    try:
        found = planning.plan(problem, world, deadline=deadline)
    except PlanningFailure:
        row.failed += 1
        row.milliseconds["total"].append(1e3 * (time.perf_counter() - began))
        return
    for stage in STAGES:
        row.milliseconds[stage].append(1e3 * found.timings.get(stage, 0.0))
    row.durations.append(found.trajectory.duration)
    row.clearances.append(1e3 * found.certificate.min_clearance)


def _table(rows: list[Row], options: argparse.Namespace) -> Table:
    title = f"medians over {options.seeds} seeds, refine {options.refine}, {options.retime}"
    table = Table(title=title)
    table.add_column("query")
    for stage in STAGES:
        table.add_column(f"{stage} ms", justify="right")
    for column in ("motion s", "clearance mm", "failed"):
        table.add_column(column, justify="right")
    for row in rows:
        cells = [_median(row.milliseconds[stage], 0) for stage in STAGES]
        more = [_median(row.durations, 2), _median(row.clearances, 1), str(row.failed)]
        table.add_row(row.query, *cells, *more)
    return table


def _median(numbers: list[float], digits: int) -> str:
    return f"{statistics.median(numbers):.{digits}f}" if numbers else "-"


if __name__ == "__main__":
    main()
