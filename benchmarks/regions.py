"""Regions against OMPL: build time, coverage, query time and duration. `--help` tells the rest.

Regions are grown for the bundled scenes `ur5e_pickup` and `panda_shelf`. Then random queries are
planned twice, by GCS inside the regions (RRTConnect where it cannot) and by RRTConnect alone; both
are refined, timed and certified with the defaults. Both ends of a query are random free
configurations of the domain, "anywhere" or "inside" some region, and the straight line between
them is blocked: where it is free nobody searches.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import planning
from planning.domain.arrays import Array
from planning.errors import PlanningFailure

SCENES = {"ur5e_pickup": "arm", "panda_shelf": "panda"}
PLANNERS = ("GCS", "RRTConnect")
# How finely the straight line is looked at, and how many configurations are drawn at once.
_RESOLUTION = 0.0125
_DRAWN = 4000


@dataclass
class Run:
    """One query by one planner.

    Attributes:
        milliseconds: Of the whole plan.
        search: Of its search [ms].
        duration: Of the motion [s]; None if there is none.
        is_inside: Whether the path came from the regions.
        fallback: Why not.
    """

    milliseconds: float
    search: float = 0.0
    duration: float | None = None
    is_inside: bool = False
    fallback: str = ""


@dataclass
class Block:
    """The queries of one kind in one scene."""

    scene: str
    where: str
    seconds: float
    num_regions: int
    coverage: float
    coverage_error: float
    digest: str
    runs: dict[str, list[Run]] = field(default_factory=lambda: {name: [] for name in PLANNERS})


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--queries", type=int, default=50, help="of each kind in each scene")
    parser.add_argument("--regions", type=int, default=60, help="at most so many per scene")
    parser.add_argument("--allowed", type=float, default=10.0, help="seconds per plan")
    parser.add_argument("--build", type=float, default=600.0, help="seconds for growing regions")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scene", choices=sorted(SCENES), action="append", help="only these")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    blocks = [block for scene in options.scene or SCENES for block in _measure(scene, options)]
    if options.json:
        print(json.dumps([_summary(block) for block in blocks]))
    else:
        Console().print(_table(blocks))


def _measure(scene: str, options: argparse.Namespace) -> Iterator[Block]:
    path = planning.bundled_folder("scenes") / f"{scene}.scene.yaml"
    world = planning.load_world(planning.read_scene(path))
    began = time.perf_counter()
    regions = planning.grow_regions(
        world,
        SCENES[scene],
        deadline=planning.Deadline.after(options.build, time.monotonic),
        options=planning.RegionOptions(num_regions=options.regions),
        seed=options.seed,
    )
    seconds = time.perf_counter() - began
    for where in ("anywhere", "inside"):
        facts = (len(regions.regions), regions.coverage, regions.coverage_error, regions.digest)
        block = Block(scene, where, seconds, *facts)
        queries = _queries(world, regions, where, np.random.default_rng(options.seed))
        for _, query in zip(range(options.queries), queries, strict=False):
            for planner in PLANNERS:
                block.runs[planner].append(_run(world, regions, query, planner, options.allowed))
        yield block


def _queries(
    world: planning.World, regions: planning.Regions, where: str, rng: np.random.Generator
) -> Iterator[tuple[Array, Array]]:
    """Yield random starts and goals, for ever."""
    group = world.group(regions.group)
    judge = world.collision_oracle(group, world.margins())
    while True:
        drawn = rng.uniform(regions.lower, regions.upper, (_DRAWN, len(regions.lower)))
        free = drawn[judge.are_free(drawn)]
        if where == "inside":
            free = free[[bool(regions.containing(q)) for q in free]]
        starts, goals = free[: len(free) // 2], free[len(free) // 2 :][: len(free) // 2]
        is_clear = judge.are_motions_free(starts, goals - starts, _RESOLUTION)
        yield from zip(starts[~is_clear], goals[~is_clear], strict=True)


def _run(
    world: planning.World,
    regions: planning.Regions,
    query: tuple[Array, Array],
    planner: str,
    allowed: float,
) -> Run:
    start, goal = query
    problem = planning.PlanningProblem(
        regions.group,
        planning.JointGoal(goal[None]),
        start=start,
        search=planning.SearchOptions(planner=planner, allowed_planning_time=allowed),
        regions=regions if planner == "GCS" else None,
    )
    began = time.perf_counter()
    try:
        deadline = planning.Deadline.after(allowed, time.monotonic)
        found = planning.plan(problem, world, deadline=deadline)
    except PlanningFailure as failure:
        return Run(1e3 * (time.perf_counter() - began), fallback=failure.code)
    told = found.stages.search.regions
    return Run(
        1e3 * (time.perf_counter() - began),
        1e3 * found.timings["search"],
        found.trajectory.duration,
        told is not None and told.is_inside,
        "" if told is None else told.fallback,
    )


def _summary(block: Block) -> dict[str, Any]:
    """Return what there is to say of a block."""
    runs = block.runs
    pairs = [
        (ours, theirs)
        for ours, theirs in zip(*(runs[name] for name in PLANNERS), strict=True)
        if ours.is_inside and theirs.duration is not None
    ]
    reasons = [run.fallback for run in runs["GCS"] if run.fallback]
    told = {name: getattr(block, name) for name in Block.__dataclass_fields__ if name != "runs"}
    return {
        **told,
        "queries": len(runs["GCS"]),
        "inside": sum(run.is_inside for run in runs["GCS"]),
        "reasons": {reason: reasons.count(reason) for reason in sorted(set(reasons))},
        "solved": {name: sum(run.duration is not None for run in runs[name]) for name in PLANNERS},
        "plan_ms": {name: _median(runs[name], lambda run: run.milliseconds) for name in PLANNERS},
        "inside_ms": _both(pairs, lambda run: run.milliseconds),
        "inside_search_ms": _both(pairs, lambda run: run.search),
        "inside_duration": _both(pairs, lambda run: run.duration or 0.0),
        "quicker": sum((ours.duration or 0) < 0.99 * (b.duration or 0) for ours, b in pairs),
        "slower": sum((ours.duration or 0) > 1.01 * (b.duration or 0) for ours, b in pairs),
    }


def _median(runs: list[Run], measure: Callable[[Run], float]) -> float | None:
    return statistics.median(map(measure, runs)) if runs else None


def _both(pairs: list[tuple[Run, Run]], measure: Callable[[Run], float]) -> dict[str, float | None]:
    return {name: _median([pair[k] for pair in pairs], measure) for k, name in enumerate(PLANNERS)}


def _table(blocks: list[Block]) -> Table:
    table = Table(title="GCS inside regions and RRTConnect, both refined; medians of those inside")
    columns = ("scene", "ends", "build s", "regions", "coverage %", "inside", "solved", "plan ms")
    for column in (*columns, "search ms", "motion s", "quicker / slower by 1 %"):
        table.add_column(column, justify="right")
    for block in blocks:
        told = _summary(block)
        table.add_row(
            block.scene,
            block.where,
            f"{block.seconds:.0f}",
            str(block.num_regions),
            f"{100 * block.coverage:.1f} +- {100 * block.coverage_error:.1f}",
            f"{told['inside']} of {told['queries']}",
            _cell(told["solved"], "d"),
            _cell(told["inside_ms"], ".0f"),
            _cell(told["inside_search_ms"], ".0f"),
            _cell(told["inside_duration"], ".3f"),
            f"{told['quicker']} / {told['slower']}",
        )
    return table


def _cell(both: dict[str, Any], form: str) -> str:
    return " / ".join("-" if x is None else format(x, form) for x in both.values())


if __name__ == "__main__":
    main()
