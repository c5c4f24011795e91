"""Numbers of many runs in few: medians, means, 95th percentiles, and the JSON object."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.motion_bench_maker.runs import GoalKind, Run, Runs

STAGES = ("goals", "search", "shortcut", "refine", "retime", "certify")


@dataclass(frozen=True)
class Spread:
    """Median, mean and 95th percentile (linear between the nearest ranks)."""

    median: float
    mean: float
    p95: float

    @classmethod
    def of(cls, numbers: Sequence[float]) -> "Spread | None":
        """Return the spread of some numbers; None if there are none."""
        if not numbers:
            return None
        return cls(
            float(np.median(numbers)), float(np.mean(numbers)), float(np.percentile(numbers, 95))
        )


def stage_names(runs: Sequence[Run]) -> tuple[str, ...]:
    """Return the stages that the table has: the known ones, and any that a plan also names."""
    seen = {name for run in runs for name in run.stages_ms}
    return (*STAGES, *sorted(seen - set(STAGES)))


def stage_times(runs: Sequence[Run], stage: str) -> list[float]:
    """Return the milliseconds of a stage in the runs that were solved and have it."""
    return [run.stages_ms[stage] for run in runs if stage in run.stages_ms]


def of_goal(runs: Sequence[Run], goal: GoalKind) -> list[Run]:
    """Return the runs with that kind of goal."""
    return [run for run in runs if run.goal == goal]


def document(done: Runs, drake: Runs | None) -> dict[str, Any]:
    """Return everything as one JSON object, joint goals on top and pose goals in `pose`."""
    top = _document(done, drake, "joint")
    top["load_ms"], top["reload_ms"] = _rounded(done.load_ms), _rounded(done.reload_ms)
    top["pose"] = _document(done, drake, "pose")
    return top


def ratio(done: Runs, drake: Runs, goal: GoalKind) -> float | None:
    """Return Drake's median time over ours on the problems that both planned."""
    theirs = of_goal(drake.runs, goal)
    names = {run.problem.name for run in theirs}
    ours = [run for run in of_goal(done.runs, goal) if run.problem.name in names]
    if not ours:
        return None
    return float(np.median([r.total_ms for r in theirs]) / np.median([r.total_ms for r in ours]))


def _document(done: Runs, drake: Runs | None, goal: GoalKind) -> dict[str, Any]:
    runs = of_goal(done.runs, goal)
    solved = [run for run in runs if run.solved]
    stages = {name: stage_times(runs, name) for name in stage_names(runs)}
    return {
        "problems": len(done.problems),
        "valid": len(done.problems) - len(done.invalid),
        "solved": len(solved),
        "free": sum(run.free for run in solved),
        "total_ms": _rounded([run.total_ms for run in runs]),
        "cpu_ms": _rounded([run.cpu_ms for run in runs]),
        "stages_ms": {name: _rounded(times)["median"] for name, times in stages.items() if times},
        "length": {"median": _rounded([run.length for run in solved])["median"]},
        "duration_s": {"median": _rounded([run.duration for run in solved])["median"]},
        "lower_bound_s": {"median": _rounded([run.lower_bound for run in solved])["median"]},
        "improved": _share([run.improved for run in solved]),
        "bounds": [
            {
                "problem": run.problem.name,
                "duration_s": round(run.duration, 3),
                "lower_bound_s": round(run.lower_bound, 3),
                "improved": run.improved,
            }
            for run in solved
        ],
        "failures": [{"problem": r.problem.name, "code": r.failure} for r in runs if r.failure],
        "not_free": [run.problem.name for run in solved if not run.free],
        "drake_only": None if drake is None else _drake_only(done, drake, goal),
    }


def _drake_only(done: Runs, drake: Runs, goal: GoalKind) -> dict[str, Any]:
    runs = of_goal(drake.runs, goal)
    times = ratio(done, drake, goal)
    return {
        "problems": len(drake.problems),
        "valid": len(drake.problems) - len(drake.invalid),
        "solved": sum(run.solved for run in runs),
        "free": sum(run.free for run in runs),
        "total_ms": _rounded([run.total_ms for run in runs]),
        "ratio": None if times is None else round(times, 2),
    }


def _share(claims: Sequence[bool]) -> float | None:
    return round(sum(claims) / len(claims), 3) if claims else None


def _rounded(numbers: Sequence[float]) -> dict[str, float | None]:
    spread = Spread.of(numbers)
    if spread is None:
        return {"median": None, "mean": None, "p95": None}
    return {name: round(number, 3) for name, number in vars(spread).items()}
