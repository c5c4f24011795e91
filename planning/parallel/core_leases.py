"""CoreLeases: CPU cores that several processes lease from a shared pool by file locks.

A core is a file with an exclusive lock (flock(2)). The operating system releases the lock when the
last process that has the file open ends, so a killed process leaks no core.
"""

import fcntl
import os
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from pathlib import Path


class CoreLeases:
    """Pool of CPU cores, shared by all processes that use the same folder of lock files."""

    def __init__(self, folder: Path, count: int) -> None:
        """Share `count` cores through lock files in a folder, which is created if needed."""
        self._folder = folder
        self._count = count

    @contextmanager
    def lent(self, wanted: int) -> Generator[int]:
        """Lease up to `wanted` cores that are free now, possibly 0; yield their number."""
        with ExitStack() as held:
            lent = 0
            for k in range(self._count):
                if lent < wanted and self._take(k, held):
                    lent += 1
            yield lent

    def _take(self, k: int, held: ExitStack) -> bool:
        """Try to lock core k until `held` closes; return whether that succeeded."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            file = os.open(self._folder / f"{k}", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        except OSError:
            return False
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(file)
            return False
        held.callback(os.close, file)
        return True
