"""What `benchmarks/mbm.py` does once its process is pinned."""

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.motion_bench_maker.bounds import print_bounds
from benchmarks.motion_bench_maker.peers import print_peers
from benchmarks.motion_bench_maker.problems import data_folder, read_problems, round_robin
from benchmarks.motion_bench_maker.robots import ROBOTS, robot_files, robot_library
from benchmarks.motion_bench_maker.runs import Bench, Runs
from benchmarks.motion_bench_maker.summary import document
from benchmarks.motion_bench_maker.table import GOALS, print_tables
from planning.kernel.native import kernel_name


def bench(
    options: argparse.Namespace, core: int, clock: Callable[[], float] = time.monotonic
) -> None:
    """Plan, judge and print.

    Args:
        options: Those of the command.
        core: That the process is pinned to.
        clock: Monotonic seconds, of plans.

    Raises:
        DataMissing: The problems or the robot are not where they should be.
    """
    file = options.problems or data_folder() / f"problems_{options.robot}.json"
    problems = round_robin(read_problems(file, options.robot))[: options.limit]
    spec = ROBOTS[options.robot]
    if options.jerk:
        spec = spec.with_jerk(options.jerk)
    files = robot_files(options.models or data_folder() / "models", spec)
    with tempfile.TemporaryDirectory() as folder:
        library = robot_library(files, problems[0].joints, Path(folder))
        arm = Bench(files, library, options.refine, clock)
        arm.run_all(problems[:1], GOALS, kernel=True)  # warms up, not counted
        done = arm.run_all(problems, GOALS, kernel=True)
        drake, note = _drake_only(arm, done, options.drake)
    if options.json:
        print(json.dumps(document(done, drake)))
        return
    head = (
        f"{options.robot}, {len(problems)} problems, refine {options.refine}, "
        f"jerk {options.jerk or 'not limited'}, core {core}, "
        f"kernel {kernel_name()}; the "
        "first plans of the process warmed up and are not counted; failed plans count in total"
    )
    print_tables(done, drake, head, note)
    if options.refine != "none":
        print_bounds(done)
    print_peers(done, options.robot, options.refine)


def _drake_only(arm: Bench, done: Runs, count: int) -> tuple[Runs | None, str]:
    """Plan the first problems again with the kernel off."""
    if count <= 0:
        return None, "Drake only: not asked for"
    some = done.problems[:count]
    arm.run_all(some[:1], GOALS, kernel=False)  # warms up, not counted
    note = f"Drake only (kernel off): the first {len(some)} problems of the above"
    return arm.run_all(some, GOALS, kernel=False), note
