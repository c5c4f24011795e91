"""wayproof restore: make a database of what `wayproof backup` wrote."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from planning.errors import WayproofError
from service.backup import restore as read_backup
from service.cli.options import AsJson
from service.cli.output import print_json
from service.cli.serve import settings_of

_WHERE = "The data folder to make; by default as `wayproof serve` has it."


def restore(
    file: Annotated[Path, typer.Argument(help="What `wayproof backup` wrote.")],
    *,
    data_dir: Annotated[Path | None, typer.Option(help=_WHERE)] = None,
    as_json: AsJson = False,
) -> None:
    """Restore a backup where there are no records yet; all of it is verified before."""
    chosen: dict[str, Any] = {} if data_dir is None else {"data_dir": data_dir}
    settings = settings_of(chosen)
    try:
        found = read_backup(settings, file)
    except WayproofError as fault:
        typer.echo(f"nothing was restored: {fault.detail}", err=True)
        raise typer.Exit(1) from fault
    except OSError as fault:
        what = f"{fault.strerror or fault}: {fault.filename or file}"
        typer.echo(f"the backup cannot be restored: {what}", err=True)
        raise typer.Exit(1) from fault
    if as_json:
        print_json({**asdict(found), "data_dir": str(settings.data_dir.resolve())})
        return
    what = f"{found.num_jobs:,} jobs, {found.num_artifacts:,} artifacts"
    typer.echo(f"restored {what} to {settings.data_dir.resolve()}")
