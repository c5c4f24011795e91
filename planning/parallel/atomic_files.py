"""Files that other processes see either whole or not at all, and not for ever."""

import os
import tempfile
from contextlib import suppress
from pathlib import Path


def write_atomically(target: Path, text: str) -> None:
    """Write a text file in one step; its folder is created if needed.

    Raises:
        OSError: It cannot be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".part") as part:
        written = Path(part) / target.name
        written.write_text(text, "utf-8")
        written.replace(target)


def write_durably(target: Path, content: bytes) -> None:
    """Write a file in one step, so that it survives a power cut; its folder is created if needed.

    Raises:
        OSError: It cannot be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".part") as part:
        written = Path(part) / target.name
        with written.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        written.replace(target)
    folder = os.open(target.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def evict_oldest(
    folder: Path, most_bytes: int, pattern: str = "*.json", in_use: float = 0.0
) -> None:
    """Remove the files of a folder that were not touched for longest, if there is too much.

    Args:
        folder: Whose files whoever uses them touches, so that they stay.
        most_bytes: Of all together; the last one that was touched stays whatever its size.
        pattern: Of their names.
        in_use: Those that were touched so shortly before the last one stay [s].

    Raises:
        OSError: One cannot be removed; one that is gone already is no fault.
    """
    found: list[tuple[float, int, Path]] = []
    for file in folder.glob(pattern):
        with suppress(FileNotFoundError):
            status = file.stat()
            found.append((status.st_mtime, status.st_size, file))
    total = 0
    newest = max((touched for touched, *_ in found), default=0.0)
    for place, (touched, size, file) in enumerate(sorted(found, reverse=True)):
        total += size
        if place and total > most_bytes and newest - touched >= in_use:
            file.unlink(missing_ok=True)
