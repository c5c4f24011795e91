"""Memory of worker processes: what they use, and what they may.

A server looks at what its workers use; it is late where they take memory faster than it looks. So a
worker is also given a limit by the kernel, further up, beyond which it gets no more.
"""

import asyncio
import os
import resource
from collections.abc import Callable
from pathlib import Path

_PAGE = os.sysconf("SC_PAGE_SIZE")
# More than seven numbers need [bytes].
_LINE = 256
# Between looks at what a running task uses [s].
_PERIOD = 0.1
# Of what it may use; the kernel counts what was asked for, even if it was never written.
_HARD = 1.5


def resident(pid: int) -> int:
    """Return the memory that a process has in use [bytes], 0 if it is gone (proc(5): statm)."""
    try:
        # Asked after every run: a file object and its path would take ten times as long.
        file = os.open(f"/proc/{pid}/statm", os.O_RDONLY)
        try:
            return int(os.read(file, _LINE).split()[1]) * _PAGE
        finally:
            os.close(file)
    except (OSError, IndexError, ValueError):
        return 0


def limit_own(bound: int) -> None:
    """Have the kernel refuse this process memory far beyond a bound [bytes] (setrlimit(2)).

    What it has by now comes on top: a forked process has all that its parent imported.
    """
    mapped = Path("/proc/self/statm").read_text(encoding="ascii").split()[5]
    most = int(_HARD * bound) + int(mapped) * _PAGE
    _, highest = resource.getrlimit(resource.RLIMIT_DATA)
    if highest != resource.RLIM_INFINITY:
        most = min(most, highest)
    resource.setrlimit(resource.RLIMIT_DATA, (most, highest))


class MemoryWatch:
    """Looks at a process while a task runs in it.

    Attributes:
        used: The most that was seen [bytes].
        is_exceeded: Whether that was too much.
    """

    def __init__(self, pid: int, bound: int | None, on_exceeded: Callable[[], None]) -> None:
        """Begin.

        Args:
            pid: Of the process.
            bound: What it may use [bytes]; None for all.
            on_exceeded: Called once, if it uses more.
        """
        self.used = 0
        self.is_exceeded = False
        self._pid = pid
        self._bound = bound
        self._on_exceeded = on_exceeded
        self._timer: asyncio.TimerHandle | None = None
        if bound is not None:
            self._timer = asyncio.get_running_loop().call_later(_PERIOD, self._look)

    def end(self) -> None:
        """Look no more."""
        if self._timer is not None:
            self._timer.cancel()

    def _look(self) -> None:
        self.used = max(self.used, resident(self._pid))
        if self._bound is not None and self.used > self._bound:
            self.is_exceeded = True
            self._on_exceeded()
        else:
            self._timer = asyncio.get_running_loop().call_later(_PERIOD, self._look)
