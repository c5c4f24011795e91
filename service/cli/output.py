"""What people see: progress bars and summaries."""

from collections.abc import Iterable, Mapping
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from service.client.events import Event
from service.client.models import Failure, Group, Plan, PlanResult

console = Console(highlight=False)
error_console = Console(stderr=True, highlight=False)

# As the timings call them; the last is all of planning, for which the scene was loaded before.
_TIMES = {
    **{stage: stage for stage in ("goals", "search", "shortcut", "refine", "retime", "certify")},
    "total": "total",
    "load": "not in the total: loading the scene",
}
_TURNS = {"revolute", "continuous"}


def follow(title: str, events: Iterable[Event]) -> dict[str, Any]:
    """Show events as a progress bar until they end; return the data of the last one."""
    last: dict[str, Any] = {}
    columns = (
        TextColumn(f"{title:<16}"),
        BarColumn(bar_width=32),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=1.0)
        for event in events:
            last = event.data
            is_whole = last.get("state") == "succeeded"
            told = 1.0 if is_whole else last.get("progress")
            bar.update(task, completed=told, description=_described(event))
    return last


def _described(event: Event) -> str:
    error = event.data.get("tracking_error")
    if error is not None:
        return f"{event.data['state']}, t = {event.data['time']:.2f} s, off by {error:.1e}"
    return str(event.data.get("stage") or event.data.get("state") or event.type)


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
    if result is None:
        return {"state": job.state}
    facts = {
        f"{told}, ms": f"{1000 * job.timings[name]:.0f}"
        for name, told in _TIMES.items()
        if name in job.timings
    }
    return {**facts, **_motion_facts(result, unit), **_proof_facts(result)}


def _motion_facts(result: PlanResult, unit: str) -> dict[str, str]:
    funnel, search, retime = result.stages.goals.funnel, result.stages.search, result.stages.retime
    refine = result.stages.refine
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


def _proof_facts(result: PlanResult) -> dict[str, str]:
    proof = result.certificate
    nearest = "nothing to hit" if proof.min_clearance is None else f"{proof.min_clearance:.4f}"
    return {
        "proven": "yes" if proof.proven else "NO",
        "min clearance, m": nearest,
        "between": " and ".join(name for name in proof.pair if name),
        "at, s": f"{proof.time:.3f}",
        **{
            f"check: {check.name}": "passed" if check.passed else "FAILED" for check in proof.checks
        },
        "digest": result.digest[:16],
    }


def show_failure(what: str, failure: Failure | None) -> None:
    """Print why something has no result, on stderr."""
    if failure is None:
        error_console.print(f"{what}: no result, and no reason given")
        return
    stage = f" (stage {failure.stage})" if failure.stage else ""
    error_console.print(f"{what} failed{stage}: {failure.code}: {failure.detail}", markup=False)
