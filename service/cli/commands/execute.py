"""wayproof execute: carry out a plan that a running server has."""

from typing import Annotated

import typer

from service.cli.options import SERVER_VARIABLE, AsJson, ServerUrl, above_zero
from service.cli.output import console, print_json
from service.cli.runs import executed
from service.cli.session import session


def execute(
    plan: Annotated[str, typer.Argument(help="Id of the plan.")],
    *,
    server: ServerUrl = None,
    speed: Annotated[float, typer.Option(help="Pace; 1 is real time.", callback=above_zero)] = 1.0,
    as_json: AsJson = False,
) -> None:
    """Carry out a plan of a running server in simulation; Ctrl-C stops it."""
    if server is None:
        message = f"is needed, for a private server has no plans; or set {SERVER_VARIABLE}"
        raise typer.BadParameter(message, param_hint="--server")
    with session(server) as client:
        execution = executed(client, plan, plan, speed)
    if as_json:
        print_json(execution)
    elif execution.status is not None:
        error = execution.status.max_tracking_error
        console.print(f"{execution.id} {execution.state}, never off by more than {error:.1e}")
