"""What options of several commands have in common."""

import math
from typing import Annotated

import typer

from service.cli.scene_source import bundled_scenes

MAX_SEED = 2**32 - 1
# In place of an option: what is asked is the same then.
SERVER_VARIABLE = "WAYPROOF_SERVER"


def above_zero(number: float) -> float:
    """Return a number above zero, as an option has it.

    Raises:
        typer.BadParameter: It is none.
    """
    if not (math.isfinite(number) and number > 0):
        message = f"{number:g} is no number above 0"
        raise typer.BadParameter(message)
    return number


def numbers_of(text: str) -> list[float]:
    """Return the numbers of a text with commas between them.

    Raises:
        typer.BadParameter: One of them is no finite number.
    """
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError as fault:
        message = f"{text!r} is no list of numbers with commas between them"
        raise typer.BadParameter(message) from fault
    if not all(map(math.isfinite, numbers)):
        message = f"{text!r} has a number that is not finite"
        raise typer.BadParameter(message)
    return numbers


def _scenes(incomplete: str) -> list[str]:
    return [name for name in bundled_scenes() if name.startswith(incomplete)]


SceneName = Annotated[
    str, typer.Argument(help="A bundled scene, or a YAML or JSON file.", autocompletion=_scenes)
]
GroupName = Annotated[str | None, typer.Option(help="What moves; else the first group.")]
ServerUrl = Annotated[
    str | None,
    typer.Option(
        envvar=SERVER_VARIABLE,
        help="URL of a running server; else a private one runs for as long as it takes.",
    ),
]
Seed = Annotated[int, typer.Option(help="Of all randomness.", min=0, max=MAX_SEED)]
Seconds = Annotated[float, typer.Option(help="Allowed planning time [s].", callback=above_zero)]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else, to stdout.")]
