"""FileStore: content-addressed storage of files by sha256, and folders made of them."""

import hashlib
import shutil
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from planning.domain.value import digest
from planning.errors import AssetNotFound
from planning.parallel.atomic_files import write_durably


@dataclass(frozen=True)
class FileStore:
    """Content-addressed store of immutable files; several processes may share a folder.

    Attributes:
        folder: With `bytes/`, each file named by its sha256, and `folders/`, which are made of
            these and may be removed while nothing uses them.
    """

    folder: Path

    @property
    def meshes(self) -> Path:
        """Folder of converted meshes; they can be made again."""
        return self.folder / "meshes"

    def put(self, content: bytes) -> str:
        """Store some bytes, and return their sha256.

        Raises:
            OSError: They cannot be written.
        """
        sha256 = hashlib.sha256(content).hexdigest()
        if self._read(sha256) != content:
            write_durably(self._file(sha256), content)
        else:
            self._file(sha256).touch()  # it is in use again
        return sha256

    def get(self, sha256: str) -> bytes:
        """Return the bytes with this sha256.

        Raises:
            AssetNotFound: They are not stored, or damaged.
        """
        content = self._read(sha256)
        if content is None or hashlib.sha256(content).hexdigest() != sha256:
            state = "missing" if content is None else "damaged"
            message = f"a stored file of the scene, sha256 {sha256}, is {state}"
            raise AssetNotFound(message, {"uri": f"sha256:{sha256}", "known": []})
        return content

    def materialize(self, sha256: Mapping[str, str]) -> Path:
        """Return a folder that holds these files and no others, every byte compared.

        Args:
            sha256: By path relative to the folder.

        Raises:
            AssetNotFound: One is not stored.
            OSError: The folder cannot be written.
        """
        target = self.folder_of(sha256)
        if _hash_files(target) != dict(sha256):
            self._write_folder(target, dict(sha256))
        with suppress(OSError):
            target.touch()  # it is in use again
        return target

    def folder_of(self, sha256: Mapping[str, str]) -> Path:
        """Return the folder of these files after `materialize`."""
        return self.folder / "folders" / digest(sha256)

    def _write_folder(self, target: Path, expected: Mapping[str, str]) -> None:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".part") as part:
            written = Path(part) / target.name
            for path, sha256 in expected.items():
                file = written / path
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(self.get(sha256))
            with suppress(OSError):  # another process was first
                written.replace(target)
            if _hash_files(target) != expected:
                shutil.rmtree(target)
                written.replace(target)

    def _file(self, sha256: str) -> Path:
        return self.folder / "bytes" / sha256

    def _read(self, sha256: str) -> bytes | None:
        try:
            return self._file(sha256).read_bytes()
        except FileNotFoundError:
            return None


def _hash_files(folder: Path) -> dict[str, str]:
    """Return the sha256 of every file in a folder, by path; empty if there is no folder."""
    return {
        file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in folder.rglob("*")
        if file.is_file()
    }
