"""What refinement brings cars: durations with it and without it.

The bundled parking scene with several seeds of the search, and random yards, each planned twice: as
it was found, and refined. A first plan, which imports engines, is not counted.
`benchmarks/cars.py --help`.
"""

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import planning  # noqa: E402
from benchmarks.car_problems.yards import CarProblem, parking, yard  # noqa: E402
from planning.domain.request.options import RefineOptions, RetimeOptions  # noqa: E402
from planning.errors import PlanningFailure  # noqa: E402


@dataclass(frozen=True)
class Run:
    """One problem, planned twice.

    Attributes:
        name: Of the problem.
        seed: Of the search.
        before: Duration as it was found [s].
        after: And refined [s].
        stops: Rests on the way, before and after.
        refine_ms: What refinement took [ms].
        total_ms: What the refined plan took in all [ms].
    """

    name: str
    seed: int
    before: float
    after: float
    stops: tuple[int, int]
    refine_ms: float
    total_ms: float


def main(arguments: list[str] | None = None, clock: Callable[[], float] = time.monotonic) -> None:
    """Run and print; plans have the seconds that are allowed by the clock."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10, help="of the search, in the parking scene")
    parser.add_argument("--yards", type=int, default=20, help="random scenes")
    parser.add_argument("--retime", choices=["toppra", "ruckig"], default="toppra")
    parser.add_argument("--allowed", type=float, default=5.0, help="seconds per plan")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    rows: dict[str, list[Run | None]] = {}
    for kind, run in _runs(options, clock):
        rows.setdefault(kind, []).append(run)
    if options.json:
        told = {k: [None if r is None else asdict(r) for r in runs] for k, runs in rows.items()}
        print(json.dumps(told))
    else:
        Console().print(_table(rows, options))


def _runs(
    options: argparse.Namespace, clock: Callable[[], float]
) -> Iterator[tuple[str, Run | None]]:
    scenes = [parking("parked", reverse=True)]
    _run(scenes[0], 0, options, clock)
    scenes += [parking("passed", reverse=reverse) for reverse in (True, False)]
    for scene in scenes:
        for seed in range(options.seeds):
            yield scene.name, _run(scene, seed, options, clock)
    for reverse in (True, False):
        for k in range(options.yards):
            kind = f"{options.yards} yards, {'both ways' if reverse else 'one way'}"
            yield kind, _run(yard(k, reverse=reverse), 0, options, clock)


def _run(
    scene: CarProblem, seed: int, options: argparse.Namespace, clock: Callable[[], float]
) -> Run | None:
    retime = RetimeOptions(method=options.retime)
    plans: list[planning.MotionPlan] = []
    for method in ("none", "trajopt"):
        problem = scene.problem(seed, retime=retime, refine=RefineOptions(method))
        search = replace(problem.search, allowed_planning_time=options.allowed)
        problem = replace(problem, search=search)
        deadline = planning.Deadline.after(options.allowed, clock)
        try:
            plans.append(planning.plan(problem, scene.world, deadline=deadline))
        except PlanningFailure:
            return None
    found, refined = plans
    return Run(
        scene.name,
        seed,
        found.trajectory.duration,
        refined.trajectory.duration,
        (found.stages.retime.stops, refined.stages.retime.stops),
        1e3 * refined.timings["refine"],
        1e3 * refined.timings["total"],
    )


def _table(rows: dict[str, list[Run | None]], options: argparse.Namespace) -> Table:
    table = Table(title=f"medians, {options.retime}; the share is after / before")
    table.add_column("problem")
    for column in ("planned", "quicker", "before s", "after s", "share", "worst", "stops"):
        table.add_column(column, justify="right")
    for column in ("refine ms", "total ms"):
        table.add_column(column, justify="right")
    for kind, all_runs in rows.items():
        runs = [run for run in all_runs if run is not None]
        if not runs:
            table.add_row(kind, "0")
            continue
        shares = [run.after / run.before for run in runs]
        quicker = sum(share < 1 - 1e-6 for share in shares)
        numbers = [
            statistics.median(run.before for run in runs),
            statistics.median(run.after for run in runs),
            statistics.median(shares),
            max(shares),
        ]
        stops = [statistics.median(run.stops[i] for run in runs) for i in range(2)]
        times = [
            statistics.median(run.refine_ms for run in runs),
            statistics.median(run.total_ms for run in runs),
        ]
        cells = [f"{len(runs)} of {len(all_runs)}", f"{quicker}"]
        cells += [*(f"{number:.2f}" for number in numbers), f"{stops[0]:g} to {stops[1]:g}"]
        table.add_row(kind, *cells, *(f"{number:.0f}" for number in times))
    return table


if __name__ == "__main__":
    main()
