"""Server: `wayproof serve` as a process of its own."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

import httpx

_LISTENS = re.compile(r"listens on (\S+)")
_PERIOD = 0.005
# What a start, and an end that was asked for, take at most on a busy machine [s].
LONGEST_START, LONGEST_END = 120.0, 60.0


class NotStarted(Exception):
    """The server ended, or said nothing in time; with what it printed last."""


class Server:
    """Runs on a data folder until it is ended; it ends by itself with the process that made it.

    Attributes:
        url: Where it listens, once it does.
    """

    def __init__(
        self,
        folder: Path,
        log: Path,
        environment: Mapping[str, str] | None = None,
        program: str = "service",
    ) -> None:
        """Start it on a free port; `listen` waits for it.

        Args:
            folder: Its data folder.
            log: What it prints comes after what is there.
            environment: More variables, `WAYPROOF_*`.
            program: The module that is run.
        """
        self.url = ""
        self._log = log
        self._skip = self._log.stat().st_size if self._log.exists() else 0
        command = [sys.executable, "-m", program, "serve", "--port", "0", "--leashed"]
        command += ["--data-dir", str(folder)]
        with log.open("ab") as out:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=out,
                stderr=out,
                env={**os.environ, **(environment or {})},
                cwd=Path(__file__).parents[2],
            )

    def __enter__(self) -> Self:
        """Wait until it listens."""
        try:
            self.listen()
        except BaseException:
            self.kill()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it."""
        self.end()

    @property
    def pid(self) -> int:
        """The number of its process."""
        return self._process.pid

    @property
    def code(self) -> int | None:
        """What it has ended with; None while it runs."""
        return self._process.poll()

    @property
    def printed(self) -> str:
        """What it has printed."""
        with self._log.open("rb") as log:
            log.seek(self._skip)
            return log.read().decode(errors="replace")

    def listen(self) -> None:
        """Wait until it says where it listens.

        Raises:
            NotStarted: It does not.
        """
        until = time.monotonic() + LONGEST_START
        while not (found := _LISTENS.search(self.printed)):
            if self._process.poll() is not None or time.monotonic() > until:
                self.kill()
                raise NotStarted(self.printed[-2000:])
            pause(_PERIOD)
        self.url = found[1]

    def be_ready(self) -> None:
        """Wait until it answers that it is ready.

        Raises:
            NotStarted: It does not.
        """
        until = time.monotonic() + LONGEST_START
        with httpx.Client(trust_env=False) as http:
            while not self._is_ready(http):
                if time.monotonic() > until:
                    raise NotStarted(self.printed[-2000:])
                pause(_PERIOD)

    def tell(self) -> None:
        """Ask it to end (SIGTERM)."""
        self._process.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it without a word."""
        self._process.kill()
        self._process.wait()
        self._close()

    def end(self) -> int | None:
        """Ask it to end (SIGTERM) and return its exit code, None if it had to be killed."""
        self.tell()
        try:
            return self._process.wait(LONGEST_END)
        except subprocess.TimeoutExpired:
            self.kill()
            return None
        finally:
            self._close()

    def _is_ready(self, http: httpx.Client) -> bool:
        try:
            return http.get(f"{self.url}/readyz").is_success
        except httpx.TransportError:
            return False

    def _close(self) -> None:
        if self._process.stdin is not None:
            self._process.stdin.close()


def pause(seconds: float) -> None:
    """Let time pass."""
    threading.Event().wait(seconds)
