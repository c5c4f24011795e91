"""Atomic file writes (temporary file, then rename) and eviction of the oldest files of a folder."""

import os
import tempfile
from contextlib import suppress
from pathlib import Path


def write_atomically(target: Path, content: str | bytes) -> None:
    """Write a file atomically: readers see the old or the new content, never a part.

    Its folder is created if needed. The file is not synced to disk (see `write_durably`).

    Raises:
        OSError: The file cannot be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".part") as temporary_folder:
        temporary_file = Path(temporary_folder) / target.name
        temporary_file.write_bytes(content.encode() if isinstance(content, str) else content)
        temporary_file.replace(target)


def write_durably(target: Path, content: bytes) -> None:
    """Write a file atomically and sync it (fsync(2)), so that it survives a power cut.

    Its folder is created if needed.

    Raises:
        OSError: The file cannot be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".part") as temporary_folder:
        temporary_file = Path(temporary_folder) / target.name
        with temporary_file.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary_file.replace(target)
    folder = os.open(target.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def evict_oldest(
    folder: Path, max_bytes: int, pattern: str = "*.json", min_age: float = 0.0
) -> None:
    """Remove the least recently used files of a folder until its size is within a limit.

    Args:
        folder: Folder of the files; every use of a file updates its modification time (touch).
        max_bytes: Limit of the total size [bytes]; the newest file stays whatever its size.
        pattern: Glob pattern of the file names.
        min_age: Files at most this much older than the newest one stay [s].

    Raises:
        OSError: A file cannot be removed; a file that is already gone is no error.
    """
    files: list[tuple[float, int, Path]] = []
    for file in folder.glob(pattern):
        with suppress(FileNotFoundError):
            status = file.stat()
            files.append((status.st_mtime, status.st_size, file))
    total = 0
    newest = max((touched for touched, *_ in files), default=0.0)
    for rank, (modified_at, size, file) in enumerate(sorted(files, reverse=True)):
        total += size
        if rank and total > max_bytes and newest - modified_at >= min_age:
            file.unlink(missing_ok=True)
