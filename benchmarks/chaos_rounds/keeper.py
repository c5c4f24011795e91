"""Keeper: has a server run on one data folder, and starts it again after each of its ends."""

import signal
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from benchmarks.chaos_rounds.journal import Journal
from benchmarks.chaos_rounds.machines import Machines, OwnMachine
from benchmarks.serving.processes import Process, descendants, open_files
from benchmarks.serving.server import NotStarted, Server, pause

# Within which what a server ran is gone after it [s]: a worker sees that its server has ended. On a
# machine that is too busy it may take longer, if the processor has not had so much time for it.
_GONE_WITHIN, _AT_LONGEST = 10.0, 120.0
_AGAIN = 0.5
# uvicorn ends in order, and then by the signal that it was sent.
_AS_TOLD = (0, -signal.SIGTERM)
_PROGRAM = "benchmarks.chaos_rounds.poisoned_server"
# Another server has taken the database over (docs/how-to/operations.md).
_TAKEN = 3


def _never() -> bool:
    return False


class Keeper:
    """Starts, ends and kills a server.

    Attributes:
        losses: How often it was killed.
        starts: How often it came to listen.
        refused: How often it could not start, because of a fault that was there on purpose.
        stood_down: How often it ended because another server had taken the database over.
    """

    def __init__(
        self,
        folder: Path,
        log: Path,
        environment: Mapping[str, str],
        journal: Journal,
        machines: Machines | None = None,
        *,
        is_shared: bool = False,
    ) -> None:
        """Run on a data folder; call `start`.

        Args:
            folder: The data folder.
            log: What servers print.
            environment: More variables of the server.
            journal: Is told of what is left running, and of starts that fail.
            machines: Where its workers are; None for below it.
            is_shared: Whether another server works on its database, which may take it over.
        """
        self.losses = 0
        self.starts = 0
        self.refused = 0
        self.stood_down = 0
        self._as_told = (*_AS_TOLD, *((_TAKEN,) if is_shared else ()))
        self._folder = folder
        self._log = log
        self._environment = environment
        self._journal = journal
        self._machines = machines or OwnMachine()
        self._server: Server | None = None
        self._left: set[Process] = set()
        self._below: set[Process] = set()
        self._lock = threading.Lock()

    @property
    def url(self) -> str:
        """Where the server listens; empty while there is none."""
        server = self._server
        return "" if server is None else server.url

    @property
    def pid(self) -> int | None:
        """The number of the server's process; None while there is none."""
        server = self._server
        return None if server is None else server.pid

    def workers(self) -> list[Process]:
        """Return the processes that run tasks; none while there is no server."""
        return [] if self._server is None else self._machines.workers(self._server.pid)

    def hosts(self) -> list[Process]:
        """Return the processes that own workers elsewhere; none while there is no server."""
        return [] if self._server is None else self._machines.hosts(self._server.pid)

    def forkserver(self) -> Process | None:
        """Return the process that workers are forked from."""
        if self._server is None:
            return None
        below = descendants(self._server.pid)
        parents = {parent for _, parent in below}
        own = [one for one, parent in below if parent == self._server.pid and one.pid in parents]
        return own[0] if own else None

    def lose_machine(self, choice: float) -> None:
        """Have one of the machines go with all that runs there, and another one come.

        Args:
            choice: Which, 0 to 1.
        """
        with self._lock:
            self._left |= set(self._machines.lose(choice))

    def start(self, is_troubled: Callable[[], bool] = _never) -> None:
        """Start the server, again and again while there is trouble about.

        Args:
            is_troubled: Whether a fault is there now that may keep it from its start.

        Raises:
            NotStarted: It cannot start, without trouble.
        """
        while True:
            had_trouble = is_troubled()
            server = Server(self._folder, self._log, self._environment, _PROGRAM)
            try:
                server.listen()
            except NotStarted as fault:
                if not (had_trouble or is_troubled()):
                    self._journal.blame("a server starts", "server", str(fault)[-500:])
                    raise
                self.refused += 1
                pause(_AGAIN)
            else:
                self._server = server
                self.starts += 1
                return

    def kill(self, after: float | None = None) -> None:
        """End the server without a word, or so long after it was told to end [s]."""
        with self._lock:
            server = self._take()
            self.losses += 1
            if after is not None:
                server.tell()
                pause(after)
            server.kill()
            self.losses += 1

    def end(self) -> None:
        """Have the server end by itself."""
        with self._lock:
            code = self._take().end()
        if code not in self._as_told:
            what = f"the server ended with {code} after SIGTERM"
            self._journal.blame("a server ends when it is told to", "server", what)

    def revive(self, is_troubled: Callable[[], bool] = _never) -> None:
        """Start the server again if it has ended by itself; raises as `start`."""
        with self._lock:
            server = self._server
            if server is None:
                return
            if (code := server.code) is None:
                self._below = {process for process, _ in descendants(server.pid)}
                return
            self._take()
            server.kill()
            self.losses += 1
            if code == _TAKEN and code in self._as_told:
                self.stood_down += 1
            else:
                what = f"the server ended with {code}: {server.printed[-500:]}"
                self._journal.blame("a server ends when it is told to", "server", what)
            self.start(is_troubled)

    def open_files(self) -> dict[str, int]:
        """Return how many pipes and the like the server has open, which are for its workers."""
        assert self._server is not None
        kinds = open_files(self._server.pid)
        return {kind: kinds[kind] for kind in ("pipe", "anon_inode", "socket")}

    def check_gone(self) -> None:
        """Blame every process of an ended server that still runs."""
        began = time.monotonic()
        used = {one: one.cpu_seconds for one in self._left}
        while alive := [one for one in self._left if one.is_alive]:
            waited = time.monotonic() - began
            is_starved = all(
                one.wants_to_run and one.cpu_seconds - used[one] < _GONE_WITHIN for one in alive
            )
            if waited > (_AT_LONGEST if is_starved else _GONE_WITHIN):
                break
            pause(0.05)
        for process in alive:
            what = f"runs {_GONE_WITHIN:g} s after its server has ended: {_name(process.pid)}"
            self._journal.blame("nothing is left running", f"process {process.pid}", what)
        self._left.clear()

    def _take(self) -> Server:
        """Return the server, which clients do not find any more."""
        server = self._server
        assert server is not None
        # One that has ended by itself has none below it any more.
        self._left |= {process for process, _ in descendants(server.pid)} | self._below
        self._left |= {*self._machines.workers(server.pid), *self._machines.hosts(server.pid)}
        self._server, self._below = None, set()
        return server


def _name(pid: int) -> str:
    try:
        text = Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode()
        return f"{text[:120]}, {Path(f'/proc/{pid}/status').read_text().split('State:')[1][:12]}"
    except (OSError, IndexError):
        return "gone"
