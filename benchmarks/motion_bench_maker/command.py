"""What `benchmarks/mbm.py` does once its process is pinned."""

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.motion_bench_maker.bounds import print_bounds
from benchmarks.motion_bench_maker.comparison import print_comparison
from benchmarks.motion_bench_maker.loads import Load
from benchmarks.motion_bench_maker.peers.earlier import print_peers
from benchmarks.motion_bench_maker.peers.roboplan import roboplan_peers
from benchmarks.motion_bench_maker.peers.side_by_side import peer_documents, print_side_by_side
from benchmarks.motion_bench_maker.problems import data_folder, read_problems, round_robin
from benchmarks.motion_bench_maker.robots import ROBOTS, robot_files, robot_library
from benchmarks.motion_bench_maker.runs import Bench, Method, Runs, row_name
from benchmarks.motion_bench_maker.summary import document
from benchmarks.motion_bench_maker.table import GOALS, print_tables
from planning import RefineObjective
from planning.kernel.native import kernel_name

# On a busy machine the processor time of the one thread is what the wall clock would be alone.
_CLOCKS: dict[str, Callable[[], float]] = {"wall": time.monotonic, "cpu": time.process_time}


def bench(options: argparse.Namespace, core: int, clock: Callable[[], float] | None = None) -> None:
    """Plan, judge and print.

    Args:
        options: Those of the command.
        core: That the process is pinned to.
        clock: Monotonic seconds, of plans; None for the one that the options name.

    Raises:
        DataMissing: The problems or the robot are not where they should be.
        PeerMissing: A planner that was asked for is not installed.
    """
    file = options.problems or data_folder() / f"problems_{options.robot}.json"
    problems = round_robin(read_problems(file, options.robot))[: options.limit]
    spec = ROBOTS[options.robot]
    if options.jerk:
        spec = spec.with_jerk(options.jerk)
    files = robot_files(options.models or data_folder() / "models", spec)
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        peers = ()
        if "roboplan" in options.peers:
            peers = roboplan_peers(stack, options.peer_python, files, options.clock)
        library = robot_library(files, problems[0].joints, Path(folder))
        methods: list[Method] = list(options.refine)
        clock = clock or _CLOCKS[options.clock]
        loads = tuple(options.loads)
        weights = _objective(options.objective)
        arm = Bench(files, library, tuple(methods), clock, weights, peers, loads)
        arm.run_all(problems[:1], GOALS, kernel=True)  # warms up, not counted
        done = arm.run_all(problems, GOALS, kernel=True)
        is_compared = len(methods) * len(loads) > 1
        count = 0 if is_compared else options.drake
        drake, note = _drake_only(replace(arm, peers=()), done, count)
    if options.json:
        told = _documents(done, methods, loads, drake)
        print(json.dumps({**told, "peers": peer_documents(done)} if peers else told))
        return
    head = (
        f"{options.robot}, {len(problems)} problems, refine {', '.join(methods)}, objective "
        f"{_described(options.objective)}, jerk {options.jerk or 'not limited'}, loads "
        f"{', '.join(loads)}, core {core}, "
        f"{options.clock} clock, "
        f"kernel {kernel_name()}; the "
        "first plans of the process warmed up and are not counted; failed plans count in total"
    )
    if is_compared:
        print_comparison(done, methods, head, loads)
        print_side_by_side(done, methods)
        return
    print_tables(done, drake, head, note)
    if methods != ["none"]:
        print_bounds(done)
    print_side_by_side(done, methods)
    print_peers(done, options.robot, methods[0])


def _documents(
    done: Runs, methods: list[Method], loads: tuple[Load, ...], drake: Runs | None
) -> dict[str, Any]:
    """Return a document for each method, for each load if there are several, or the only one."""
    by_name = {
        row_name(method, load): document(done.of_method(method).of_load(load), drake)
        for method, load in product(methods, loads)
    }
    return by_name if len(by_name) > 1 else next(iter(by_name.values()))


def _described(weights: dict[str, float] | None) -> str:
    return ", ".join(f"{name}={weight:g}" for name, weight in (weights or {"duration": 1}).items())


def _objective(weights: dict[str, float] | None) -> RefineObjective | None:
    if weights is None:
        return None
    return RefineObjective(
        weights.get("duration", 0.0),
        weights.get("smoothness", 0.0),
        weights.get("energy", 0.0),
        weights.get("path_length", 0.0),
        max_duration=weights.get("max_duration"),
    )


def _drake_only(arm: Bench, done: Runs, count: int) -> tuple[Runs | None, str]:
    """Plan the first problems again with the kernel off."""
    if count <= 0:
        return None, "Drake only: not asked for"
    some = done.problems[:count]
    arm.run_all(some[:1], GOALS, kernel=False)  # warms up, not counted
    note = f"Drake only (kernel off): the first {len(some)} problems of the above"
    return arm.run_all(some, GOALS, kernel=False), note
