"""wayproof backup: write the records to one file."""

import sqlite3
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from planning.errors import WayproofError
from service.backup import backup as write_backup
from service.cli.options import AsJson
from service.cli.output import print_json
from service.cli.serve import settings_of

_WHERE = "The server's data folder; by default as `wayproof serve` has it."


def backup(
    file: Annotated[Path, typer.Argument(help="The file to write (a .sqlite.gz).")],
    *,
    data_dir: Annotated[Path | None, typer.Option(help=_WHERE)] = None,
    as_json: AsJson = False,
) -> None:
    """Back the records up, while a server works or not; `wayproof restore` takes them back."""
    chosen: dict[str, Any] = {} if data_dir is None else {"data_dir": data_dir}
    settings = settings_of(chosen)
    try:
        found = write_backup(settings, file)
    except WayproofError as fault:
        typer.echo(f"nothing was backed up: {fault.detail}", err=True)
        raise typer.Exit(1) from fault
    except OSError as fault:
        what = f"{fault.strerror or fault}: {fault.filename or file}"
        typer.echo(f"nothing was backed up: {what}", err=True)
        raise typer.Exit(1) from fault
    except sqlite3.Error as fault:
        typer.echo(f"nothing was backed up: the database cannot be read: {fault}", err=True)
        raise typer.Exit(1) from fault
    if as_json:
        print_json({**asdict(found), "file": str(file)})
        return
    what = f"{found.num_jobs:,} jobs, {found.num_artifacts:,} artifacts"
    typer.echo(f"wrote {file}: {what}, {file.stat().st_size:,} bytes")
