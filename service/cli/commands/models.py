"""wayproof models: the robots there are."""

from typing import Annotated

import typer
from rich.table import Table

from service.cli.options import AsJson, ServerUrl
from service.cli.output import console, print_json
from service.cli.session import session
from wayproof_client.models import Model


def models(
    name: Annotated[str | None, typer.Argument(help="One of them; else their names.")] = None,
    *,
    server: ServerUrl = None,
    as_json: AsJson = False,
) -> None:
    """List the robots that scenes may name, or show the groups of one."""
    with session(server) as client:
        if name is None:
            names = client.list_models().items
            if as_json:
                print_json(names)
            else:
                console.print("\n".join(names))
            return
        model = client.get_model(name)
    if as_json:
        print_json(model)
    else:
        _show(model)


def _show(model: Model) -> None:
    console.print(f"{model.name}: {model.description}", markup=False)
    table = Table()
    for head in ("group", "joints", "tool frames", "configurations"):
        table.add_column(head, overflow="fold")
    for group in model.groups:
        table.add_row(
            group.name,
            " ".join(joint.name for joint in group.joints),
            " ".join(group.tool_frames),
            " ".join(group.configurations),
        )
    console.print(table)
