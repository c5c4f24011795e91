"""Time random paths by our retimers, by Drake's Toppra, by plain toppra and by plain ruckig.

Paths are random walks of 3 to 8 waypoints of a Panda and a UR5e, in turns, from a fixed seed; no
obstacles. Each contender times each path in its usual way under the same limits: toppra and Drake
along a cubic spline through the waypoints (Drake along our rounded path as well), ruckig from
waypoint to waypoint, state to state, at rest at each. Motions are judged by samples 1 ms apart:
ten times finer than they are usually delivered. Then curves and lines are sampled by 5 to 200
waypoints and timed by ours. `docs/explanation/benchmarks.md` says more.
"""

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
from rich.box import SIMPLE  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402

from benchmarks.retiming.contenders import CONTENDERS, JERK, YARDSTICKS  # noqa: E402
from benchmarks.retiming.judge import Verdict, judged  # noqa: E402
from benchmarks.retiming.paths import Question, random_paths  # noqa: E402
from benchmarks.retiming.sampled import Sampled, sampled  # noqa: E402
from planning.errors import RetimingFailed  # noqa: E402

# Limits count as kept up to here: a sample of a motion at its limit may be rounded.
WITHIN = 1 + 1e-4
# So many of the robots' starts have a curve and a line.
SAMPLED = 6
_COLUMNS = {
    "valid": "valid",
    "within": "within limits",
    "within_1_percent": "to 1 %",
    "use": "peak rate / limit, median / worst",
    "deviation": "off the path, median / worst rad",
    "duration": "duration s",
    "ratio": "/ ours",
    "ms": "ms, median / p95",
}


def measured(questions: Sequence[Question]) -> dict[str, list[Verdict]]:
    """Return the verdicts on every contender's motions, contenders in turns on each path."""
    found: dict[str, list[Verdict]] = {name: [] for name in CONTENDERS}
    for question in questions:
        for name, contender in CONTENDERS.items():
            work = contender(question)
            begun = time.perf_counter()
            try:
                motion = work()
            except (RetimingFailed, RuntimeError, ValueError):
                motion = None
            ms = (time.perf_counter() - begun) * 1000
            found[name].append(judged(question, motion, ms, jerk=name in JERK))
    return found


def summary(found: dict[str, list[Verdict]]) -> dict[str, dict[str, Any]]:
    """Return what is told of every contender, by name; null where it has no valid motion."""
    return {name: _of(verdicts, found[YARDSTICKS[name]]) for name, verdicts in found.items()}


def _of(verdicts: list[Verdict], ours: list[Verdict]) -> dict[str, Any]:
    good = [v for v in verdicts if v.valid]
    both = [v.duration / o.duration for v, o in zip(verdicts, ours, strict=True) if v.valid]
    return {
        "valid": len(good) / len(verdicts),
        "within": sum(v.use <= WITHIN for v in good) / len(verdicts),
        "within_1_percent": sum(v.use <= 1.01 for v in good) / len(verdicts),
        "use": _spread([v.use for v in good]),
        "deviation": _spread([v.deviation for v in good]),
        "duration_s": _median([v.duration for v in good]),
        "ratio": _median(both),
        "ms": _spread([v.milliseconds for v in verdicts]),
    }


def _median(numbers: list[float]) -> float | None:
    return float(np.median(numbers)) if numbers else None


def _spread(numbers: list[float]) -> dict[str, float] | None:
    if not numbers:
        return None
    high = float(np.percentile(numbers, 95))
    return {"median": float(np.median(numbers)), "p95": high, "worst": max(numbers)}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--paths", type=int, default=500, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true", help="print one JSON object, nothing else")
    options = parser.parse_args(arguments)
    questions = random_paths(max(1, options.paths), options.seed)
    measured(questions[:2])  # warms up, not counted
    told = summary(measured(questions))
    rows = sampled(questions[:SAMPLED], options.seed)
    if options.json:
        answer = {"paths": len(questions), "seed": options.seed, "contenders": told}
        print(json.dumps({**answer, "sampled": [asdict(row) for row in rows]}))
        return
    console = Console(width=170, highlight=False)
    console.print(f"{len(questions)} random paths of {', '.join({q.robot: 0 for q in questions})}")
    console.print(_table(told))
    console.print("the same curves and lines by more and more waypoints, medians")
    console.print(_sampled_table(rows))


def _table(told: dict[str, dict[str, Any]]) -> Table:
    table = Table(box=SIMPLE, pad_edge=False)
    table.add_column("")
    for title in _COLUMNS.values():
        table.add_column(title, justify="right")
    for name, row in told.items():
        use, away, ms = row["use"] or {}, row["deviation"] or {}, row["ms"]
        table.add_row(
            name,
            f"{row['valid']:.1%}",
            f"{row['within']:.1%}",
            f"{row['within_1_percent']:.1%}",
            f"{_cell(use.get('median'))} / {_cell(use.get('worst'))}",
            f"{_cell(away.get('median'))} / {_cell(away.get('worst'))}",
            _cell(row["duration_s"]),
            _cell(row["ratio"]),
            f"{ms['median']:.2f} / {ms['p95']:.2f}",
        )
    return table


def _sampled_table(rows: list[Sampled]) -> Table:
    table = Table(box=SIMPLE, pad_edge=False)
    for title in ("", "waypoints", "method", "duration s", "corners rounded s", "ms"):
        table.add_column(title, justify="right" if title else "left")
    for row in rows:
        numbers = _cell(row.duration_s), _cell(row.rounded_s), f"{row.ms:.1f}"
        table.add_row(row.kind, str(row.count), row.method, *numbers)
    return table


def _cell(number: float | None) -> str:
    return "-" if number is None else f"{number:.3f}"


if __name__ == "__main__":
    main()
