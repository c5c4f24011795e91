"""A server of one's own: started for one command, on a free loopback port, and stopped after it."""

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import httpx

from service.client.client import Client

# The API key for a server that asks for one: a private one does not.
KEY_VARIABLE = "WAYPROOF_API_KEY"
_START_TIMEOUT = 60.0
_STOP_TIMEOUT = 15.0
_POLL_PERIOD = 0.05


class ServerFailed(Exception):
    """The private server did not start."""


@contextmanager
def private_server(data_dir: Path | None = None) -> Generator[Client]:
    """Run a server and lend a client of it.

    It dies with this process, whatever happens: it stops when its stdin closes.

    Args:
        data_dir: Where it keeps its records; None for a folder that is deleted afterwards.

    Raises:
        ServerFailed: It did not get ready in time; with what it printed.
    """
    with tempfile.TemporaryDirectory(prefix="wayproof-") as temporary:
        folder = Path(temporary)
        announce, log = folder / "server.json", folder / "server.log"
        command = [sys.executable, "-m", "service", "serve", "--host", "127.0.0.1", "--port", "0"]
        command += ["--data-dir", str(data_dir or folder / "state")]
        command += ["--announce", str(announce), "--leashed"]
        with log.open("wb") as out:
            process = subprocess.Popen(  # noqa: S603  (our own program)
                command, stdin=subprocess.PIPE, stdout=out, stderr=out, env=_environment()
            )
        try:
            with Client(_wait_until_ready(process, announce, log)) as client:
                yield client
        finally:
            _stop(process)


def _environment() -> dict[str, str]:
    """Return this process's environment, without what guards a server that others reach."""
    own = {"WAYPROOF_AUTH": "none", "WAYPROOF_RATE_LIMIT": ""}
    return {name: value for name, value in os.environ.items() if name != KEY_VARIABLE} | own


def _wait_until_ready(process: subprocess.Popen[bytes], announce: Path, log: Path) -> str:
    """Return the server's URL once it takes jobs."""
    until = time.monotonic() + _START_TIMEOUT
    pause = threading.Event()
    while time.monotonic() < until and process.poll() is None:
        if announce.is_file() and (text := announce.read_text(encoding="utf-8")):
            url: str = json.loads(text)["url"]
            if _is_ready(url):
                return url
        pause.wait(_POLL_PERIOD)
    printed = log.read_text(encoding="utf-8", errors="replace")[-2000:]
    message = f"the private server did not start:\n{printed}"
    raise ServerFailed(message)


def _is_ready(url: str) -> bool:
    try:
        with Client(url) as client:
            return client.is_ready()
    except httpx.TransportError:
        return False


def _stop(process: subprocess.Popen[bytes]) -> None:
    if process.stdin is not None:
        process.stdin.close()
    try:
        process.wait(_STOP_TIMEOUT)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
