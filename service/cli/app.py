"""wayproof: serve, plan, demo."""

import typer

from service.cli.demo import demo
from service.cli.plan import plan
from service.cli.serve import FROM_ENVIRONMENT, serve

app = typer.Typer(
    name="wayproof",
    help="Plans robot motion and proves it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command(epilog=FROM_ENVIRONMENT)(serve)
app.command()(plan)
app.command()(demo)
