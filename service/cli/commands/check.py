"""wayproof check: whether a configuration is within limits and free."""

from typing import Annotated

import typer

from service.cli.exit_codes import ExitCode
from service.cli.goal import configuration_of, group_of
from service.cli.options import AsJson, GroupName, SceneName, ServerUrl, numbers_of
from service.cli.output import console, print_json
from service.cli.session import post, scene_text, session
from wayproof_client.models import Verdict


def check(
    scene: SceneName,
    *,
    at: Annotated[str | None, typer.Option(help="A configuration; else the scene's state.")] = None,
    positions: Annotated[
        str | None, typer.Option(help="Positions with commas between them [rad or m].")
    ] = None,
    group: GroupName = None,
    server: ServerUrl = None,
    as_json: AsJson = False,
) -> None:
    """Check one configuration: limits, collisions, and the nearest pair of bodies."""
    if at is not None and positions is not None:
        message = "goes without --at"
        raise typer.BadParameter(message, param_hint="--positions")
    numbers = None if positions is None else numbers_of(positions)
    text = scene_text(scene)
    with session(server) as client:
        posted = post(client, text)
        moving = group_of(posted, group)
        q = configuration_of(moving, at) if numbers is None else numbers
        found = client.check_configurations(
            posted.id, {"group": moving.name, "configurations": [q]}
        )
        (verdict,) = found.results
    if as_json:
        print_json(verdict)
    else:
        _show(verdict)
    if not verdict.valid:
        raise typer.Exit(ExitCode.NO_RESULT)


def _show(verdict: Verdict) -> None:
    console.print("valid" if verdict.valid else "NOT VALID")
    for fault in verdict.limit_violations:
        console.print(f"  outside its limits: {fault.model_dump(mode='json')}", markup=False)
    for pair in verdict.collisions:
        told = " and ".join(pair.bodies)
        console.print(f"  {told}: {1000 * pair.distance:.1f} mm", markup=False)
    if verdict.nearest is not None and verdict.distance is not None:
        told = " and ".join(verdict.nearest.bodies)
        console.print(f"  nearest: {told}, {1000 * verdict.distance:.1f} mm", markup=False)
