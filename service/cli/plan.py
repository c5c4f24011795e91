"""wayproof plan: one motion in one scene."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from service.cli.goal import goal_of, group_of, start_of
from service.cli.options import AsJson, GroupName, SceneName, Seconds, Seed, ServerUrl
from service.cli.output import console, error_console, print_json, show_plans, unit_of
from service.cli.runs import finished
from service.cli.session import post, scene_text, session
from wayproof_client import Client
from wayproof_client.models import Plan

# What a file has, by its ending: the whole plan, its replay, or a format of its samples.
_ENDINGS: dict[str, Literal["json", "html", "csv", "npz", "mcap", "rerun", "urscript"]] = {
    ".json": "json",
    ".csv": "csv",
    ".html": "html",
    ".npz": "npz",
    ".mcap": "mcap",
    ".rrd": "rerun",
    ".script": "urscript",
}


def plan(  # noqa: PLR0913  (one parameter per option)
    scene: SceneName,
    *,
    to: Annotated[str, typer.Option(help="A frame to bring the tool to, or a configuration.")],
    from_: Annotated[
        str | None, typer.Option("--from", help="A configuration; else the scene's state.")
    ] = None,
    group: GroupName = None,
    seed: Seed = 0,
    seconds: Seconds = 10.0,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Where to write the motion: .json (everything), .csv, .html (replay), "
            ".npz (NumPy), .mcap (Foxglove), .rrd (Rerun) or .script (URScript)."
        ),
    ] = None,
    server: ServerUrl = None,
    as_json: AsJson = False,
) -> None:
    """Plan a certified motion."""
    if out is not None and out.suffix not in _ENDINGS:
        message = f"must end in {', '.join(_ENDINGS)}"
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
        if as_json:
            print_json(job)
        else:
            show_plans({f"to {to}": job}, unit_of(moving))
        if out is not None:
            write(client, job, out)
            (error_console if as_json else console).print(f"written to {out}", markup=False)


def write(client: Client, job: Plan, out: Path) -> None:
    """Write a plan to a file, as its ending says."""
    out.parent.mkdir(parents=True, exist_ok=True)
    match _ENDINGS[out.suffix]:
        case "html":
            content = client.get_replay(job.id).encode()
        case "json":
            content = job.model_dump_json(indent=1).encode()
        case name:
            content = client.get_trajectory_as(job.id, format=name)
    out.write_bytes(content)
