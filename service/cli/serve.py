"""wayproof serve: run the service until it is told to stop."""

import gc
import json
import logging
import os
import socket
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import ValidationError
from pydantic_settings import SettingsError

from service.cli.variables import (
    nearest_setting,
    sentence_of,
    unknown_variables,
    variable_of,
)
from service.settings import Settings
from service.telemetry.logs import configure_logs
from service.workers import start_to_import

EPILOG = (
    "Settings in the environment (docs/how-to/operations.md says what they are): "
    f"{', '.join(f'WAYPROOF_{name.upper()}' for name in Settings.model_fields)}."
)
_log = logging.getLogger(__name__)
_WHERE = "Where records are kept; by default $XDG_STATE_HOME/wayproof or ~/.local/state/wayproof."


def serve(  # noqa: PLR0913  (one parameter per option)
    *,
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 for a free one.")] = None,
    data_dir: Annotated[Path | None, typer.Option(help=_WHERE)] = None,
    plan_slots: Annotated[int | None, typer.Option(help="Plans that may run at once.")] = None,
    engine: Annotated[str | None, typer.Option(help="process, ray or inline.")] = None,
    announce: Annotated[Path | None, typer.Option(hidden=True)] = None,
    leashed: Annotated[bool, typer.Option("--leashed", hidden=True)] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Log every request: WAYPROOF_LOG_LEVEL=info.")
    ] = False,
) -> None:
    """Run the service. Settings come from options, else from WAYPROOF_* in the environment."""
    chosen: dict[str, Any] = {
        "host": host,
        "port": port,
        "data_dir": data_dir,
        "plan_slots": plan_slots,
        "engine": engine,
        "log_level": "info" if verbose else None,
    }
    settings = settings_of({name: item for name, item in chosen.items() if item is not None})
    configure_logs(settings.logs)
    for variable, nearest in unknown_variables(os.environ).items():
        _log.warning(sentence_of(variable, nearest))
    bound = bind(settings.host, settings.port)
    url = url_of(bound)
    if settings.engine == "process":
        start_to_import()
    gc.disable()  # what is imported lasts: to look for garbage among it takes a tenth of the start
    from service.cli.server import CannotStart, run  # noqa: PLC0415  (takes a second)

    gc.enable()

    def tell() -> None:
        gc.freeze()  # and it will last, so no later look needs to go through it
        if announce is not None:
            announce.write_text(json.dumps({"url": url}), encoding="utf-8")
        typer.echo(f"Wayproof listens on {url}  (documentation: {url}/docs)", err=True)

    try:
        with bound:
            run(settings, bound, leashed=leashed, on_listening=tell)
    except CannotStart as fault:
        typer.echo(f"the server does not start: {fault}", err=True)
        raise typer.Exit(1) from fault


def settings_of(chosen: dict[str, Any]) -> Settings:
    """Return the settings by options and environment.

    Raises:
        typer.Exit: With 2, after a sentence for each that is wrong.
    """
    try:
        return Settings(**chosen)
    except ValidationError as fault:
        for one in fault.errors():
            name = ".".join(map(str, one["loc"]))
            told = f"the setting {name} ({variable_of(str(one['loc'][0]))}) is wrong: {one['msg']}"
            if one["type"] == "extra_forbidden":
                told = f"there is no setting {name}; the nearest is {nearest_setting(name)}"
            typer.echo(told, err=True)
        raise typer.Exit(2) from fault
    except SettingsError as fault:
        typer.echo(f"the settings are wrong: {fault}", err=True)
        raise typer.Exit(2) from fault


def bind(host: str, port: int) -> socket.socket:
    """Return a socket bound to an address.

    Raises:
        typer.Exit: It is taken, or not ours.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # By its protocol asyncio knows that it may set TCP_NODELAY, without which answers take 40 ms.
    bound = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        bound.bind((host, port))
    except OSError as fault:
        bound.close()
        typer.echo(f"cannot listen on {host}, port {port}: {fault.strerror or fault}", err=True)
        raise typer.Exit(1) from fault
    return bound


def url_of(bound: socket.socket) -> str:
    """Return the URL at which a bound socket is reached."""
    host, port = bound.getsockname()[:2]
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"
