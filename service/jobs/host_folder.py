"""The folder that the workers of a host share: copies of artifacts, and what is made of them."""

from contextvars import ContextVar
from pathlib import Path

_folder: ContextVar[Path] = ContextVar("host_folder")


def host_folder() -> Path:
    """Return the folder of the host on which a task runs; for tasks.

    Raises:
        LookupError: No task runs here, or one that reads nothing.
    """
    return _folder.get()


def set_host_folder(folder: Path) -> None:
    """Say to the tasks of this thread, or of this process, which folder the host has."""
    _folder.set(folder)


def files_folder(folder: Path) -> Path:
    """Return where copies of artifacts, and what is made of them, are in the folder of a host."""
    return folder / "files"


def artifact_path(folder: Path, digest: str) -> Path:
    """Return where the copy of an artifact is, or would be, in the folder of a host."""
    return files_folder(folder) / "bytes" / digest
