"""wayproof bench: how long one problem takes to plan, over many seeds."""

import statistics
from typing import Annotated, Any

import typer
from rich.table import Table

from service.cli.exit_codes import ExitCode
from service.cli.goal import goal_of, group_of
from service.cli.options import AsJson, GroupName, SceneName, Seconds, Seed, ServerUrl
from service.cli.output import console, print_json
from service.cli.runs import planned_all
from service.cli.session import post, scene_text, session
from wayproof_client.models import Plan


def bench(  # noqa: PLR0913  (one parameter per option)
    scene: SceneName,
    *,
    to: Annotated[str, typer.Option(help="A frame to bring the tool to, or a configuration.")],
    times: Annotated[int, typer.Option(help="How many seeds.", min=1, max=256)] = 20,
    group: GroupName = None,
    seed: Seed = 0,
    seconds: Seconds = 10.0,
    server: ServerUrl = None,
    as_json: AsJson = False,
) -> None:
    """Plan one problem with many seeds, and show planning times, durations and what is proven."""
    text = scene_text(scene)
    with session(server) as client:
        posted = post(client, text)
        moving = group_of(posted, group)
        request = {
            "scene": posted.id,
            "group": moving.name,
            "goal": goal_of(posted, moving, to),
            "search": {"allowed_planning_time": seconds},
        }
        batch = planned_all(client, [{**request, "seed": seed + i} for i in range(times)])
        plans = [client.get_plan(plan) for plan in batch.plans]
    facts = _facts(plans)
    if as_json:
        print_json(facts)
    else:
        _show(facts)
    if facts["succeeded"] < times:
        raise typer.Exit(ExitCode.NO_RESULT)


def _facts(plans: list[Plan]) -> dict[str, Any]:
    """Return counts, and quantiles over the plans that succeeded."""
    results = [(plan.timings["total"], plan.result) for plan in plans if plan.result is not None]
    proofs = [result.certificate for _, result in results if result.certificate is not None]
    motions = [result.trajectory for _, result in results if result.trajectory is not None]
    return {
        "plans": len(plans),
        "succeeded": len(results),
        "proven": sum(proof.proven for proof in proofs),
        "planning_time": _quantiles([total for total, _ in results]),
        "duration": _quantiles([motion.duration for motion in motions]),
        "failures": sorted({plan.failure.code for plan in plans if plan.failure is not None}),
    }


def _quantiles(values: list[float]) -> dict[str, float]:
    """Return the least value, the median, that below which 95 % lie, and the greatest [s]."""
    if not values:
        return {}
    ordered = sorted(values)
    p95 = ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]
    median = statistics.median(ordered)
    return {"min": ordered[0], "median": median, "p95": p95, "max": ordered[-1]}


def _show(facts: dict[str, Any]) -> None:
    table = Table(title=f"{facts['succeeded']} of {facts['plans']} found, {facts['proven']} proven")
    table.add_column("s")
    for head in ("min", "median", "p95", "max"):
        table.add_column(head, justify="right")
    for name, title in (("planning_time", "planning time"), ("duration", "motion")):
        table.add_row(title, *(f"{value:.3f}" for value in facts[name].values()))
    console.print(table)
    if facts["failures"]:
        console.print(f"failures: {', '.join(facts['failures'])}")
