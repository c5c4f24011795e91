"""PeerProcess: another planner in its own interpreter, asked by lines of JSON."""

import json
import subprocess
import threading
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

# An answer takes longer only if the peer hangs: plans have 5 s, and loading a few [s].
_LONGEST = 60.0


class PeerMissing(Exception):
    """The peer cannot be run; says what to do."""


class PeerLost(Exception):
    """The peer ended in the middle of a question, or did not answer."""


class PeerProcess:
    """Runs until it is closed; inherits the core that the benchmark is pinned to.

    Attributes:
        name: Of the peer, with its version.
    """

    def __init__(self, command: Sequence[str], how_to_install: str) -> None:
        """Start it and wait until it says who it is.

        Args:
            command: What to run: an interpreter and its script.
            how_to_install: Is told if that does not work.

        Raises:
            PeerMissing: It cannot be run, or says that it lacks something.
        """
        try:
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            )
        except OSError as fault:
            message = f"{command[0]} cannot be run ({fault.strerror}): {how_to_install}"
            raise PeerMissing(message) from fault
        try:
            greeting = self._read()
        except PeerLost as fault:
            self.close()
            message = f"{Path(command[0])} did not get as far as to begin: {how_to_install}"
            raise PeerMissing(message) from fault
        if "missing" in greeting:
            self.close()
            message = f"{command[0]}: {greeting['missing']}: {how_to_install}"
            raise PeerMissing(message)
        self.name = f"{greeting['name']} {greeting['version']}"

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it."""
        self.close()

    def ask(self, question: dict[str, Any]) -> dict[str, Any]:
        """Return the answer to a question.

        Raises:
            PeerLost: There is none.
        """
        stdin = self._process.stdin
        if stdin is None or self._process.poll() is not None:
            message = f"it has ended, with {self._process.returncode}"
            raise PeerLost(message)
        try:
            stdin.write(json.dumps(question) + "\n")
            stdin.flush()
        except OSError as fault:
            message = f"it has ended, with {self._process.wait()}"
            raise PeerLost(message) from fault
        return self._read()

    def close(self) -> None:
        """End it."""
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                stream.close()
        self._process.kill()
        self._process.wait()

    def _read(self) -> dict[str, Any]:
        """Return a line of it; one that hangs is killed, which ends the line."""
        stdout = self._process.stdout
        watch = threading.Timer(_LONGEST, self._process.kill)
        watch.start()
        try:
            line = stdout.readline() if stdout is not None else ""
        finally:
            watch.cancel()
        if not line.endswith("\n"):
            message = f"it ended with {self._process.wait()} instead of an answer"
            raise PeerLost(message)
        return json.loads(line)
