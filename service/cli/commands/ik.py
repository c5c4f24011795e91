"""wayproof ik: configurations that bring the tool to a frame."""

from typing import Annotated, Any

import typer
from rich.table import Table

from service.cli.exit_codes import ExitCode
from service.cli.goal import goal_of, group_of
from service.cli.options import AsJson, GroupName, SceneName, Seed, ServerUrl
from service.cli.output import console, print_json, show_failure
from service.cli.session import post, scene_text, session
from wayproof_client.models import IkSolution


def ik(  # noqa: PLR0913  (one parameter per option)
    scene: SceneName,
    *,
    to: Annotated[str, typer.Option(help="A frame to bring the tool to.")],
    group: GroupName = None,
    seed: Seed = 0,
    most: Annotated[int, typer.Option(help="How many to show; JSON has all.", min=1)] = 10,
    server: ServerUrl = None,
    as_json: AsJson = False,
) -> None:
    """Find configurations that reach a frame without a collision, the best one first."""
    text = scene_text(scene)
    with session(server) as client:
        posted = post(client, text)
        moving = group_of(posted, group)
        goal: Any = goal_of(posted, moving, to)
        found = client.solve_inverse_kinematics(
            posted.id, {"group": moving.name, "goal": goal, "seed": seed}
        )
    if as_json:
        print_json(found)
    elif found.configurations:
        console.print(_table(found.configurations[:most]))
        console.print(
            f"{len(found.configurations)} found; clear: least distance of bodies, limits: share of "
            "the range that is left, manip.: manipulability"
        )
    if not found.configurations:
        show_failure(f"the IK to {to}", found.failure)
        raise typer.Exit(ExitCode.NO_RESULT)


def _table(solutions: list[IkSolution]) -> Table:
    table = Table()
    table.add_column("positions, rad or m", no_wrap=True)
    for head in ("clear, mm", "limits", "manip."):  # with six joints it fits into 80 columns
        table.add_column(head, justify="right", no_wrap=True)
    for one in solutions:
        table.add_row(
            " ".join(f"{number:.3f}" for number in one.positions),
            "" if one.clearance is None else f"{1000 * one.clearance:.1f}",
            "" if one.limit_margin is None else f"{one.limit_margin:.3f}",
            f"{one.manipulability:.4f}",
        )
    return table
