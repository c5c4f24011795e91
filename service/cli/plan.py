"""wayproof plan: one motion in one scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from service.cli.goal import goal_of, group_of, start_of
from service.cli.options import MAX_SEED, above_zero
from service.cli.output import console, follow, show_failure, show_plans, unit_of
from service.cli.session import post, scene_text, session
from wayproof_client import Client
from wayproof_client.generated.models import Plan

if TYPE_CHECKING:
    from wayproof_client.generated.requests import PlanRequest


def plan(  # noqa: PLR0913  (one parameter per option)
    scene: Annotated[str, typer.Argument(help="A bundled scene, or a YAML or JSON file.")],
    *,
    to: Annotated[str, typer.Option(help="A frame to bring the tool to, or a configuration.")],
    from_: Annotated[
        str | None, typer.Option("--from", help="A configuration; else the scene's state.")
    ] = None,
    group: Annotated[str | None, typer.Option(help="What moves; else the first group.")] = None,
    seed: Annotated[int, typer.Option(help="Of all randomness.", min=0, max=MAX_SEED)] = 0,
    seconds: Annotated[
        float, typer.Option(help="Allowed planning time [s].", callback=above_zero)
    ] = 10.0,
    out: Annotated[
        Path | None,
        typer.Option(help="Where to write the motion: .json (everything), .csv or .html (replay)."),
    ] = None,
    server: Annotated[str | None, typer.Option(help="URL of a running server.")] = None,
) -> None:
    """Plan a certified motion. Without --server, a private one runs for as long as it takes."""
    if out is not None and out.suffix not in {".json", ".csv", ".html"}:
        message = "must end in .json, .csv or .html"
        raise typer.BadParameter(message, param_hint="--out")
    text = scene_text(scene)
    with session(server) as client:
        posted = post(client, text)
        moving = group_of(posted, group)
        request: dict[str, Any] = {
            "scene": posted.id,
            "group": moving.name,
            "start": start_of(moving, from_),
            "goal": goal_of(posted, moving, to),
            "search": {"allowed_planning_time": seconds},
            "seed": seed,
        }
        job = finished(client, f"to {to}", request)
        show_plans({f"to {to}": job}, unit_of(moving))
        if out is not None:
            write(client, job, out)
            console.print(f"written to {out}", markup=False)


def finished(client: Client, title: str, request: dict[str, Any]) -> Plan:
    """Ask for a plan, show its progress, and return it once it succeeded.

    Raises:
        typer.Exit: With 1, after a message, if it did not.
    """
    job = client.create_plan(cast("PlanRequest", request))
    follow(title, client.follow(job))
    job = client.refresh(job)
    if job.result is None:
        show_failure(f"the plan {title}", job.failure)
        raise typer.Exit(1)
    return job


def write(client: Client, job: Plan, out: Path) -> None:
    """Write a plan to a file, as its ending says."""
    out.parent.mkdir(parents=True, exist_ok=True)
    match out.suffix:
        case ".csv":
            text = client.get_trajectory_as(job.id, format="csv").decode()
        case ".html":
            text = client.get_replay(job.id)
        case _:
            text = job.model_dump_json(indent=1)
    out.write_text(text, encoding="utf-8")
