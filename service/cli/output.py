"""What people see: progress bars and summaries."""

import json
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from wayproof_client.models import Certificate, Failure, Group, Plan, Stages

console = Console(highlight=False)
error_console = Console(stderr=True, highlight=False)

# As the timings call them; the last is all of planning, for which the scene was loaded before.
_TIMES = {
    **{stage: stage for stage in ("goals", "search", "shortcut", "refine", "retime", "certify")},
    "total": "total",
    "load": "not in the total: loading the scene",
}
_TURNS = {"revolute", "continuous"}


def follow(title: str, events: Iterable[Any], total: int = 1) -> None:
    """Show the events of a job, or of so many in one stream, as a progress bar until they end.

    It goes to stderr, so that stdout has the result alone.
    """
    columns = (
        TextColumn(f"{title:<16}"),
        BarColumn(bar_width=32),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
    )
    ended = 0
    with Progress(*columns, console=error_console) as bar:
        task = bar.add_task("", total=float(total))
        for event in events:
            ended += event.event == "finished"
            share = ended if total > 1 else _share(event)
            bar.update(task, completed=share, description=_described(event))


def _share(event: Any) -> float | None:
    is_whole = getattr(event.data, "state", None) == "succeeded"
    return 1.0 if is_whole else getattr(event.data, "progress", None)


def _described(event: Any) -> str:
    data = event.data
    if event.event == "status":
        return f"{data.state}, t = {data.time:.2f} s, off by {data.tracking_error:.1e}"
    return str(getattr(data, "stage", None) or getattr(data, "state", None) or event.event)


def print_json(value: Any) -> None:
    """Print a value, or an answer as it came, as the one JSON document of stdout."""
    plain = value.model_dump(mode="json") if isinstance(value, BaseModel) else value
    print(json.dumps(plain, indent=1, ensure_ascii=False))


def unit_of(group: Group) -> str:
    """Return what lengths in a group's joint space are measured in."""
    turns = {joint.type in _TURNS for joint in group.joints}
    shifts = {joint.type == "prismatic" for joint in group.joints}
    return "rad" if turns == {True} else "m" if shifts == {True} else "rad or m"


def show_plans(plans: Mapping[str, Plan], unit: str = "rad or m") -> None:
    """Print plans that succeeded, a column each; `unit` is of joint-space lengths."""
    table = Table(title="What was planned, and what is proven of it", title_justify="left")
    table.add_column("")
    for name in plans:
        table.add_column(name, justify="right")
    columns = [_facts(job, unit) for job in plans.values()]
    for row in dict.fromkeys(row for column in columns for row in column):
        table.add_row(row, *(column.get(row, "") for column in columns))
    console.print(table)


def _facts(job: Plan, unit: str) -> dict[str, str]:
    result = job.result
    if result is None or result.stages is None or result.certificate is None:
        return {"state": job.state}
    facts = {
        f"{told}, ms": f"{1000 * job.timings[name]:.0f}"
        for name, told in _TIMES.items()
        if name in job.timings
    }
    proof = _proof_facts(result.certificate)
    return {**facts, **_motion_facts(result.stages, unit), **proof, "digest": result.digest[:16]}


def _motion_facts(stages: Stages, unit: str) -> dict[str, str]:
    funnel, search, retime = stages.goals.funnel, stages.search, stages.retime
    refine = stages.refine
    return {
        "IK: tried": str(funnel.tried),
        "IK: converged": str(funnel.converged),
        "IK: within limits": str(funnel.within_limits),
        "IK: collision-free": str(funnel.collision_free),
        "IK: distinct": str(funnel.distinct),
        "planner": search.planner,
        "configurations checked": str(search.num_states_checked),
        f"path length, {unit}": f"{search.length:.3f}",
        "refined": "yes" if refine.improved else f"no: {refine.reason or refine.method}",
        "timed by": retime.method,
        "duration, s": f"{retime.duration:.3f}",
    }


def _proof_facts(proof: Certificate) -> dict[str, str]:
    nearest = "nothing to hit" if proof.min_clearance is None else f"{proof.min_clearance:.4f}"
    return {
        "proven": "yes" if proof.proven else "NO",
        "min clearance, m": nearest,
        "between": " and ".join(name for name in proof.pair if name),
        "at, s": f"{proof.time:.3f}",
        **{
            f"check: {check.name}": "passed" if check.passed else "FAILED" for check in proof.checks
        },
    }


def show_failure(what: str, failure: Failure | None) -> None:
    """Print why something has no result, on stderr."""
    if failure is None:
        error_console.print(f"{what}: no result, and no reason given")
        return
    stage = f" (stage {failure.stage})" if failure.stage else ""
    error_console.print(f"{what} failed{stage}: {failure.code}: {failure.detail}", markup=False)
