"""wayproof restore: make a database of what `wayproof backup` wrote."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planning.errors import WayproofError
from service.backup import restore as read_backup
from service.cli.serve import settings_of

_WHERE = "The data folder to make; by default as `wayproof serve` has it."


def restore(
    file: Annotated[Path, typer.Argument(help="What `wayproof backup` wrote.")],
    *,
    data_dir: Annotated[Path | None, typer.Option(help=_WHERE)] = None,
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
    what = f"{found.num_jobs:,} jobs, {found.num_artifacts:,} artifacts"
    typer.echo(f"restored {what} to {settings.data_dir.resolve()}")
