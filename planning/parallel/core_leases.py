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
    def lease(self, max_cores: int) -> Generator[int]:
        """Lease up to `max_cores` cores that are free now, possibly 0; yield their number."""
        with ExitStack() as locks:
            num_leased = 0
            for k in range(self._count):
                if num_leased < max_cores and self._try_lock(k, locks):
                    num_leased += 1
            yield num_leased

    def _try_lock(self, k: int, locks: ExitStack) -> bool:
        """Try to lock core k until `locks` closes; return whether that succeeded."""
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
        locks.callback(os.close, file)
        return True
