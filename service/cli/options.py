"""What options of several commands have in common."""

import math

import typer

MAX_SEED = 2**32 - 1


def above_zero(number: float) -> float:
    """Return a number above zero, as an option has it.

    Raises:
        typer.BadParameter: It is none.
    """
    if not (math.isfinite(number) and number > 0):
        message = f"{number:g} is no number above 0"
        raise typer.BadParameter(message)
    return number
