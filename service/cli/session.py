"""A session: a private server or another one, and every failure as a message and an exit code."""

import os
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, cast

import httpx
import typer

from service.cli.exit_codes import ExitCode
from service.cli.output import error_console
from service.cli.private_server import KEY_VARIABLE, ServerFailed, private_server
from service.cli.scene_source import NoSuchScene, read_scene_text
from service.client.client import Client
from wayproof_client import ApiError
from wayproof_client.models import Scene


@contextmanager
def session(server: str | None) -> Generator[Client]:
    """Lend a client of the server at a URL, or of a private one that lives as long as this.

    Raises:
        typer.Exit: With a code after a message, if the server refuses or cannot be reached.
    """
    try:
        with private_server() if server is None else _client(server) as client:
            yield client
    except ApiError as refusal:
        error_console.print(f"the server refused: {refusal}", markup=False)
        raise typer.Exit(ExitCode.REFUSED) from refusal
    except (httpx.TransportError, httpx.InvalidURL) as fault:
        error_console.print(f"cannot reach the server: {fault}", markup=False)
        raise typer.Exit(ExitCode.UNREACHABLE) from fault
    except ServerFailed as fault:
        error_console.print(str(fault), markup=False)
        raise typer.Exit(ExitCode.UNREACHABLE) from fault


def _client(server: str) -> Client:
    # Not an option: what is on a command line, every user of the machine can read.
    return Client(server, key=os.environ.get(KEY_VARIABLE) or None)


def post(client: Client, text: tuple[bytes, str]) -> Scene:
    """Post a scene, given as its text and media type."""
    return client.create_scene(text[0], media_type=cast("Any", text[1]))


def scene_text(scene: str) -> tuple[bytes, str]:
    """Return the text of a scene and its media type.

    Raises:
        typer.Exit: After a message, if there is no such scene.
    """
    try:
        return read_scene_text(scene)
    except NoSuchScene as fault:
        error_console.print(str(fault), markup=False)
        raise typer.Exit(ExitCode.USAGE) from fault
