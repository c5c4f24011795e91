"""Artifacts: bytes by their sha256, which tasks read, and of which each host keeps copies.

The record is the database. A host copies what it lacks into a folder that its workers share, before
a task begins; a copy may be removed once nothing has used it for a while, and comes again.
"""

import hashlib
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from anyio import to_thread

from planning.parallel.atomic_files import write_atomically
from service.jobs.host_folder import artifact_path

# A copy that is in use is marked so again after so long [s].
_MARK_PERIOD = 600.0
# Number of artifacts of which it is remembered what is needed with them, and that they are marked.
_MAX_REMEMBERED = 4096


@dataclass(frozen=True)
class Artifact:
    """Some bytes that never change.

    Attributes:
        content: The bytes.
        parts: sha256 of the artifacts that are needed with it.
    """

    content: bytes
    parts: tuple[str, ...] = ()

    @property
    def digest(self) -> str:
        """The sha256 of its bytes."""
        return hashlib.sha256(self.content).hexdigest()


class ArtifactSource(Protocol):
    """Where a host gets artifacts from; what is not there is left out of what it returns."""

    async def parts(self, digests: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
        """Return which artifacts are needed with each of some."""
        ...

    async def contents(self, digests: Sequence[str]) -> Mapping[str, bytes]:
        """Return the bytes of artifacts."""
        ...


class ArtifactCopies:
    """Copies of artifacts in the folder of this host; belongs to one event loop.

    Attributes:
        folder: That the workers of this host share.
        source: Where they come from.
    """

    def __init__(self, folder: Path, source: ArtifactSource) -> None:
        """Keep copies of what a source has in a folder."""
        self.folder = folder
        self.source = source
        self._bytes = str(artifact_path(folder, ""))
        self._parts: dict[str, tuple[str, ...]] = {}
        self._marked_at: dict[str, float] = {}

    async def bring(self, digests: Sequence[str]) -> None:
        """Copy what this host lacks of some artifacts and of their parts.

        What the source does not have either is left out: the task that reads it says what that is.

        Raises:
            DBAPIError: The database does not answer.
            OSError: The folder cannot be written.
        """
        if max(len(self._parts), len(self._marked_at)) > _MAX_REMEMBERED:
            self._parts.clear()
            self._marked_at.clear()
        unknown = [digest for digest in digests if digest not in self._parts]
        if unknown:
            self._parts |= await self.source.parts(unknown)
        wanted = [each for digest in digests for each in (digest, *self._parts.get(digest, ()))]
        missing = self._missing(wanted)  # quicker than a thread
        if missing:
            contents = await self.source.contents(missing)
            await to_thread.run_sync(self._write, contents)
        await self._mark([each for each in wanted if each not in missing])

    def _missing(self, digests: Iterable[str]) -> list[str]:
        """Return which copies are not there, by names of files, which are quicker than paths."""
        folder = self._bytes
        return [each for each in digests if not os.path.isfile(f"{folder}/{each}")]  # noqa: PTH113

    def _write(self, contents: Mapping[str, bytes]) -> None:
        for digest, content in contents.items():
            write_atomically(artifact_path(self.folder, digest), content)

    async def _mark(self, digests: Iterable[str]) -> None:
        """Mark copies as in use, if they were not so lately: files that are old may be removed."""
        now = time.monotonic()
        due = [
            digest
            for digest in digests
            if now - self._marked_at.get(digest, -_MARK_PERIOD) >= _MARK_PERIOD
        ]
        if due:
            await to_thread.run_sync(_touch, [artifact_path(self.folder, each) for each in due])
            self._marked_at |= dict.fromkeys(due, now)


def _touch(paths: Sequence[Path]) -> None:
    for path in paths:
        with suppress(FileNotFoundError):
            os.utime(path)
