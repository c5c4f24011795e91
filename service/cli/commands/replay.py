"""wayproof replay: plan again what a bundle is of, and compare."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from service.cli.exit_codes import ExitCode
from service.cli.options import AsJson
from service.cli.output import console, error_console, print_json


def replay(
    bundle: Annotated[Path, typer.Argument(help="A bundle.zip, or the folder it was unpacked to.")],
    *,
    as_json: AsJson = False,
) -> None:
    """Plan again from a bundle and say whether the same bytes come out; no server is asked."""
    if not bundle.exists():
        message = f"there is no {bundle}"
        raise typer.BadParameter(message, param_hint="BUNDLE")
    # They bring Drake with them, which `--help` does without.
    from service.plans.bundle.reader import BundleInvalid  # noqa: PLC0415
    from service.plans.bundle.replay import replay_bundle  # noqa: PLC0415

    try:
        with error_console.status("planning again"):
            found = replay_bundle(bundle)
    except BundleInvalid as fault:
        error_console.print(str(fault), markup=False)
        raise typer.Exit(ExitCode.USAGE) from fault
    if as_json:
        print_json({**asdict(found), "is_same": found.is_same})
    else:
        console.print(found.text, markup=False)
    if not found.is_same:
        raise typer.Exit(ExitCode.NO_RESULT)
