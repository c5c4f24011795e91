"""SmallDisk: a folder that can be full, and whose files can be made read-only.

It is ext4 in a file, where that may be mounted, or else a file system in memory, or else a limit on
the size of files.
"""

import os
import resource
import subprocess
from collections.abc import Iterator, Sequence
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
        image = folder.with_suffix(".ext4")
        in_memory = ["mount", "-t", "tmpfs", "-o", f"size={megabytes}m", "wayproof-chaos"]
        # In memory, a file that is open can be written although it is immutable.
        self.is_real = (
            _works(["truncate", "-s", f"{megabytes}M", str(image)])
            and _works(["mkfs.ext4", "-q", "-m", "0", str(image)])
            and _works(["mount", "-o", "loop", str(image), str(folder)])
        ) or _works([*in_memory, str(folder)])
        # What serves PostgreSQL's tables is another user.
        folder.chmod(0o755)

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

    @contextmanager
    def read_only(self, files: Sequence[Path]) -> Iterator[None]:
        """Have nothing written to some files for a while, not even by root or where they are open.

        Raises:
            OSError: A file is gone, or the file system knows no immutable files.
        """
        with _immutable(files):
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


@contextmanager
def _immutable(files: Sequence[Path]) -> Iterator[None]:
    """Set the flag of chattr(1), and clear it."""
    names = [str(file) for file in files]
    try:
        if not _works(["chattr", "+i", *names]):
            message = f"cannot be made immutable: {names}"
            raise OSError(message)
        yield
    finally:
        _works(["chattr", "-i", *names])


def _works(command: Sequence[str]) -> bool:
    try:
        return subprocess.run(command, check=False, capture_output=True).returncode == 0
    except FileNotFoundError:
        return False
