"""Plan MotionBenchMaker's problems and let a referee of its own judge every motion.

Problems and robots are read from a folder beside the checkout (`shared/mbm`), or from that of the
environment variable WAYPROOF_MBM. One process, one core, one thread. Every valid problem is planned
twice with the default options: to its goal configuration, and to the pose of the tool there. A plan
has 5 s. The first plans of the process, which import and warm up, are not counted; loading a world
is reported apart. Limits: Panda 2.175 (joints 1 to 4) and 2.61 rad/s, and 15, 7.5, 10, 12.5, 15,
20, 20 rad/s^2; UR5 pi rad/s and 10 rad/s^2 for every joint. With --refine the last table has,
problem by problem, what no motion beats; several methods share one table.
`docs/explanation/benchmarks.md` says more.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
METHODS = ("none", "trajopt", "auto", "drake")
# As `motion_bench_maker/loads.py` has them, which is imported once the process is pinned.
LOADS = ("none", "torque", "tool", "zone", "all")
PEERS = ("roboplan",)
# `make bench-peers` installs them there.
PEER_PYTHON = ROOT / "build" / "peers" / "bin" / "python"
OBJECTIVES = ("duration", "smoothness", "energy", "path_length", "max_duration")
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "DRAKE_NUM_THREADS")


def main(arguments: Sequence[str] | None = None) -> None:
    """Keep to one core, run and print."""
    options = parser().parse_args(arguments)
    run(options, _pin())


def run(options: argparse.Namespace, core: int) -> None:
    """Run and print, in a process that is pinned to a core."""
    sys.path.insert(0, str(ROOT))
    # numpy and Drake look at cores and threads when they are imported: only now.
    from benchmarks.motion_bench_maker.command import bench  # noqa: PLC0415
    from benchmarks.motion_bench_maker.peers.process import PeerMissing  # noqa: PLC0415
    from benchmarks.motion_bench_maker.problems import DataMissing  # noqa: PLC0415

    try:
        bench(options, core)
    except (DataMissing, PeerMissing) as fault:
        sys.exit(f"mbm.py: {fault}")


def parser() -> argparse.ArgumentParser:
    """Return what reads the command line."""
    reader = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    reader.add_argument("--robot", choices=["panda", "ur5"], default="panda")
    reader.add_argument("--problems", type=Path, metavar="FILE", help="another file of problems")
    reader.add_argument(
        "--models", type=Path, metavar="DIR", help="another folder of <robot>/<robot>.urdf, .srdf"
    )
    reader.add_argument(
        "--limit",
        type=_positive,
        metavar="N",
        help="only the first N of a round-robin over the sets",
    )
    reader.add_argument(
        "--refine",
        type=_methods,
        default=("none",),
        metavar="METHOD,...",
        help=f"of {', '.join(METHODS)}; several plan each problem in turns and share one table",
    )
    reader.add_argument(
        "--objective",
        type=_weights,
        metavar="NAME=WEIGHT,...",
        help=f"what refinement minimizes: a sum of {', '.join(OBJECTIVES)}",
    )
    reader.add_argument(
        "--clock",
        choices=["wall", "cpu"],
        default="wall",
        help="by which plans are timed and have their 5 s; cpu: processor time, on a busy machine",
    )
    reader.add_argument(
        "--jerk",
        type=_positive,
        metavar="J",
        help="limit every joint to J rad/s^3 and 15 rad/s^2, and time by ruckig",
    )
    reader.add_argument(
        "--loads",
        type=_loads,
        default=("none",),
        metavar="LOAD,...",
        help=f"of {', '.join(LOADS)}: torques with 1 kg in the tool, tool speed, a speed zone, all "
        "at once; several share one table",
    )
    reader.add_argument(
        "--drake",
        type=int,
        default=14,
        metavar="N",
        help="plan the first N again with the kernel off, for the ratio (default 14; 0: do not)",
    )
    reader.add_argument(
        "--peers",
        nargs="+",
        choices=PEERS,
        default=(),
        help="other planners: each plans every problem after ours, in its own process, on our core",
    )
    reader.add_argument(
        "--peer-python",
        type=Path,
        default=PEER_PYTHON,
        metavar="FILE",
        help="an interpreter that has them (default: build/peers, made by make bench-peers)",
    )
    reader.add_argument("--json", action="store_true", help="print one JSON object, nothing else")
    return reader


def _positive(word: str) -> int:
    number = int(word)
    if number < 1:
        message = f"{number} is less than 1"
        raise argparse.ArgumentTypeError(message)
    return number


def _methods(word: str) -> tuple[str, ...]:
    """Return the names of a list of methods."""
    return _names(word, METHODS)


def _loads(word: str) -> tuple[str, ...]:
    """Return the names of a list of loads."""
    return _names(word, LOADS)


def _names(word: str, known: Sequence[str]) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(word.split(",")))
    unknown = set(names) - set(known)
    if unknown:
        message = f"{', '.join(sorted(unknown))}: it must be of {', '.join(known)}"
        raise argparse.ArgumentTypeError(message)
    return names


def _weights(word: str) -> dict[str, float]:
    """Return the weights of a sum of objectives, by name."""
    pairs = [part.partition("=") for part in word.split(",")]
    unknown = {name for name, _, _ in pairs} - set(OBJECTIVES)
    if unknown:
        message = f"{', '.join(sorted(unknown))}: it must be of {', '.join(OBJECTIVES)}"
        raise argparse.ArgumentTypeError(message)
    return {name: float(weight or 1) for name, _, weight in pairs}


def _pin() -> int:
    """Keep to one core and to one thread; return the core."""
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    return core


if __name__ == "__main__":
    main()
