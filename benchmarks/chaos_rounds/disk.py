"""SmallDisk: a folder that can be full: a small file system in memory, else a limit on files."""

import os
import resource
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_MEGABYTE = 2**20


class SmallDisk:
    """A folder that can be full, as far as the machine permits that (Linux, root).

    Attributes:
        folder: Is on it.
        is_real: Whether it is a file system of its own.
    """

    def __init__(self, folder: Path, megabytes: int) -> None:
        """Make it; `close` takes it away."""
        folder.mkdir(parents=True)
        self.folder = folder
        size = f"size={megabytes}m"
        mount = ["mount", "-t", "tmpfs", "-o", size, "wayproof-chaos", str(folder)]
        try:
            done = subprocess.run(mount, check=False, capture_output=True)
        except FileNotFoundError:
            self.is_real = False
        else:
            self.is_real = done.returncode == 0

    @contextmanager
    def full(self, pid: int | None, *, is_limit: bool) -> Iterator[None]:
        """Leave no room for a while.

        A file system of its own is filled to the last byte. Databases then still write into what
        their files have; a limit on the size of files (`RLIMIT_FSIZE`) lets a process write
        nothing at all, and is what there is where the disk is not real.

        Args:
            pid: Of the process that may be limited; None without one.
            is_limit: Whether it is limited even if the disk is real.
        """
        if self.is_real and not is_limit:
            with self._filled():
                yield
        elif pid is not None:
            with _limited(pid):
                yield
        else:
            yield

    def close(self) -> None:
        """Take it away, with all that is on it."""
        if self.is_real:
            subprocess.run(["umount", "--lazy", str(self.folder)], check=True, capture_output=True)

    @contextmanager
    def _filled(self) -> Iterator[None]:
        filler = self.folder / "filler"
        try:
            with filler.open("wb") as file:
                size = 0
                for step in (_MEGABYTE, 4096):
                    with suppress(OSError):
                        while True:
                            os.posix_fallocate(file.fileno(), size, step)
                            size += step
                yield
        finally:
            filler.unlink()


@contextmanager
def _limited(pid: int) -> Iterator[None]:
    before = resource.prlimit(pid, resource.RLIMIT_FSIZE)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (1, before[1]))
    try:
        yield
    finally:
        with suppress(ProcessLookupError):
            resource.prlimit(pid, resource.RLIMIT_FSIZE, before)
