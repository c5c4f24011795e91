"""wayproof keys: make, list, revoke and rotate API keys, in the database itself."""

from collections.abc import Generator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table
from sqlalchemy.exc import SQLAlchemyError

from planning.errors import WayproofError
from service.cli.options import AsJson
from service.cli.output import console, print_json
from service.cli.serve import settings_of
from service.jobs.store.sql.database import open_engine
from service.security.keys import ApiKey, KeyStore, NewKey
from service.security.scopes import Scope

COMMANDS = typer.Typer(
    name="keys",
    help="API keys, for servers that ask for them (WAYPROOF_AUTH=keys).",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
type Name = Annotated[str, typer.Argument(help="Whom or what the key is for.")]
type Known = Annotated[str, typer.Argument(help="Name or id of a key.")]
type DataDir = Annotated[
    Path | None, typer.Option(help="Of the server; by default as `wayproof serve` has it.")
]


@COMMANDS.command()
def create(
    name: Name,
    scope: Annotated[list[Scope], typer.Option(help="What it is good for; may be given again.")],
    days: Annotated[float | None, typer.Option(min=0, help="After which it expires.")] = None,
    data_dir: DataDir = None,
) -> None:
    """Make a key and print it, once: it is not kept."""
    with _store(data_dir) as store:
        now = datetime.now(UTC)
        expires_at = None if days is None else now + timedelta(days=days)
        _show_new(store.create(name, scope, now, expires_at))


@COMMANDS.command("list")
def list_keys(*, data_dir: DataDir = None, as_json: AsJson = False) -> None:
    """List all keys, without their secrets."""
    now = datetime.now(UTC)
    with _store(data_dir) as store:
        keys = store.all()
    if as_json:
        print_json([_as_plain(key, now) for key in keys])
        return
    table = Table()
    for title in ("name", "id", "scopes", "created", "expires", "state"):
        table.add_column(title, overflow="fold")
    for key in keys:
        table.add_row(
            key.name, key.id, " ".join(sorted(key.scopes)), _instant(key.created_at),
            _instant(key.expires_at), _state(key, now),
        )  # fmt: skip
    console.print(table)


@COMMANDS.command()
def revoke(name: Known, data_dir: DataDir = None) -> None:
    """Have a key refused, within a second by servers that run."""
    with _store(data_dir) as store:
        for key in store.revoke(name, datetime.now(UTC)):
            typer.echo(f"revoked {key.name} ({key.id})")


@COMMANDS.command()
def rotate(
    name: Known,
    overlap: Annotated[
        float, typer.Option(min=0, help="Hours for which the key before it is still good.")
    ] = 0.0,
    data_dir: DataDir = None,
) -> None:
    """Make a key that takes the place of another one, and print it, once."""
    with _store(data_dir) as store:
        _show_new(store.rotate(name, datetime.now(UTC), timedelta(hours=overlap)))


@contextmanager
def _store(data_dir: Path | None) -> Generator[KeyStore]:
    """Lend the keys of a server's database.

    Raises:
        typer.Exit: With 1, after a sentence, if that cannot be done.
    """
    chosen: dict[str, Any] = {} if data_dir is None else {"data_dir": data_dir}
    url = settings_of(chosen).url
    try:
        engine = open_engine(url)
        try:
            store = KeyStore(engine)
            store.open()
            yield store
        finally:
            engine.dispose()
    except WayproofError as fault:
        typer.echo(fault.detail, err=True)
        raise typer.Exit(1) from fault
    except SQLAlchemyError as fault:
        reason = str(getattr(fault, "orig", None) or fault).splitlines()[0]
        typer.echo(f"cannot use the database: {reason}", err=True)
        raise typer.Exit(1) from fault
    except OSError as fault:
        reason = f"{fault.strerror or fault}: {fault.filename}"
        typer.echo(f"cannot use the database: {reason}", err=True)
        raise typer.Exit(1) from fault


def _show_new(new: NewKey) -> None:
    """Print a key on stdout, for programs, and about it on stderr."""
    scopes = ", ".join(sorted(new.key.scopes))
    until = _instant(new.key.expires_at)
    typer.echo(f"{new.key.name} is for {scopes}; expires: {until}; told only now:", err=True)
    typer.echo(new.text)


def _as_plain(key: ApiKey, now: datetime) -> dict[str, Any]:
    expires = None if key.expires_at is None else key.expires_at.isoformat()
    return {
        "name": key.name,
        "id": key.id,
        "scopes": sorted(key.scopes),
        "created_at": key.created_at.isoformat(),
        "expires_at": expires,
        "state": _state(key, now),
    }


def _instant(at: datetime | None) -> str:
    return "never" if at is None else at.strftime("%Y-%m-%d %H:%M")


def _state(key: ApiKey, now: datetime) -> str:
    if key.revoked_at is not None:
        return "revoked"
    return "valid" if key.is_valid(now) else "expired"
