"""CoreLeases: cores that several processes take and give back, whatever becomes of them.

A core is a file that a process holds a lock on (flock(2)). The kernel lets go of it when the last
process that has it open ends, so nothing is lost when one is killed.
"""

import fcntl
import os
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from pathlib import Path


class CoreLeases:
    """Lends cores to all processes that know the folder."""

    def __init__(self, folder: Path, count: int) -> None:
        """Share `count` cores through files in a folder, which is created if needed."""
        self._folder = folder
        self._count = count

    @contextmanager
    def lent(self, wanted: int) -> Generator[int]:
        """Lend at most `wanted` cores, as many as nobody has now; perhaps none."""
        with ExitStack() as held:
            lent = 0
            for k in range(self._count):
                if lent < wanted and self._take(k, held):
                    lent += 1
            yield lent

    def _take(self, k: int, held: ExitStack) -> bool:
        """Return whether core k is ours now."""
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
