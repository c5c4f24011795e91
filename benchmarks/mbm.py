"""Plan MotionBenchMaker's problems and let a referee of its own judge every motion.

Problems and robots are read from a folder beside the checkout (`shared/mbm`), or from that of the
environment variable WAYPROOF_MBM. One process, one core, one thread. Every valid problem is planned
twice with the default options: to its goal configuration, and to the pose of the tool there. A plan
has 5 s. The first plans of the process, which import and warm up, are not counted; loading a world
is reported apart. Limits: Panda 2.175 (joints 1 to 4) and 2.61 rad/s, and 15, 7.5, 10, 12.5, 15,
20, 20 rad/s^2; UR5 pi rad/s and 10 rad/s^2 for every joint. `docs/benchmarks.md` says more.
"""

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchmarks.motion_bench_maker.runs import Bench, Runs

ROOT = Path(__file__).resolve().parents[1]
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "DRAKE_NUM_THREADS")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and print."""
    options = _parser().parse_args(arguments)
    core = _pin()
    sys.path.insert(0, str(ROOT))
    # numpy and Drake count cores and threads when they are imported: only now.
    from benchmarks.motion_bench_maker.problems import DataMissing  # noqa: PLC0415

    try:
        _run(options, core)
    except DataMissing as fault:
        sys.exit(f"mbm.py: {fault}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", choices=["panda", "ur5"], default="panda")
    parser.add_argument("--problems", type=Path, metavar="FILE", help="another file of problems")
    parser.add_argument(
        "--models", type=Path, metavar="DIR", help="another folder of <robot>/<robot>.urdf, .srdf"
    )
    parser.add_argument(
        "--limit", type=int, metavar="N", help="only the first N of a round-robin over the sets"
    )
    parser.add_argument("--refine", choices=["none", "trajopt"], default="none")
    parser.add_argument(
        "--drake",
        type=int,
        default=14,
        metavar="N",
        help="plan the first N again with the kernel off, for the ratio (default 14; 0: do not)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object, nothing else")
    return parser


def _pin() -> int:
    """Keep to one core and to one thread; return the core."""
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    return core


def _run(options: argparse.Namespace, core: int) -> None:
    from benchmarks.motion_bench_maker.problems import (  # noqa: PLC0415
        data_folder,
        read_problems,
        round_robin,
    )
    from benchmarks.motion_bench_maker.robots import (  # noqa: PLC0415
        ROBOTS,
        robot_files,
        robot_library,
    )
    from benchmarks.motion_bench_maker.runs import Bench  # noqa: PLC0415
    from benchmarks.motion_bench_maker.summary import document  # noqa: PLC0415
    from benchmarks.motion_bench_maker.table import print_tables  # noqa: PLC0415

    file = options.problems or data_folder() / f"problems_{options.robot}.json"
    problems = round_robin(read_problems(file, options.robot))[: options.limit]
    files = robot_files(options.models or data_folder() / "models", ROBOTS[options.robot])
    with tempfile.TemporaryDirectory() as folder:
        library = robot_library(files, problems[0].joints, Path(folder))
        bench = Bench(files, library, options.refine)
        bench.run_all(problems[:1], ("joint", "pose"), kernel=True)  # warms up, not counted
        done = bench.run_all(problems, ("joint", "pose"), kernel=True)
        drake, note = _drake_only(bench, done, options.drake)
    if options.json:
        print(json.dumps(document(done, drake)))
        return
    head = (
        f"{options.robot}, {len(problems)} problems, refine {options.refine}, core {core}; the "
        "first plans of the process warmed up and are not counted; failed plans count in total"
    )
    print_tables(done, drake, head, note)


def _drake_only(bench: "Bench", done: "Runs", count: int) -> "tuple[Runs | None, str]":
    """Plan the first problems again with the kernel off."""
    from benchmarks.motion_bench_maker.runs import has_kernel_switch  # noqa: PLC0415

    if count <= 0:
        return None, "Drake only: not asked for"
    if not has_kernel_switch():
        return None, "Drake only: left out, as this version has no kernel to turn off"
    some = done.problems[:count]
    bench.run_all(some[:1], ("joint", "pose"), kernel=False)
    runs = bench.run_all(some, ("joint", "pose"), kernel=False)
    return runs, f"Drake only (kernel off): the first {len(some)} problems of the above"


if __name__ == "__main__":
    main()
