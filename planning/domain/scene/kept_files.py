"""KeptFiles: the files of a robot or object by content hash (sha256)."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from planning.domain.value import Value, digest
from planning.errors import SceneInvalid

_NUM_DIGITS = 64


@dataclass(frozen=True, eq=False)
class KeptFiles(Value):
    """Files of one robot or one mesh, as they were when the scene was first loaded.

    Paths are relative to the folder that all of the files are in, with "/" between their parts.

    Attributes:
        named: Name in the scene: a robot's model, or a mesh's uri.
        main: Path of the robot's description, or of the mesh.
        card: Path of the robot.yaml that goes with it; "" for none.
        sha256: Of the bytes of every file, by path; `main` and `card` are among them.
    """

    named: str
    main: str
    card: str
    sha256: Mapping[str, str]

    @property
    def content(self) -> str:
        """sha256 of all paths and bytes, independent of the name in the scene."""
        return digest(self.sha256)

    @property
    def as_json(self) -> dict[str, Any]:
        """The same as JSON."""
        return {
            "named": self.named,
            "main": self.main,
            "card": self.card,
            "sha256": dict(self.sha256),
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "KeptFiles":
        """Build from the result of `as_json`.

        Raises:
            SceneInvalid: A path leaves the folder, or is none of the files; or a sha256 is
                malformed.
        """
        found = cls(content["named"], content["main"], content["card"], dict(content["sha256"]))
        for path, sha256 in found.sha256.items():
            parts = PurePosixPath(path).parts
            is_inside = bool(parts) and parts[0] != "/" and ".." not in parts
            is_digest = len(sha256) == _NUM_DIGITS and set(sha256) <= set("0123456789abcdef")
            if not (is_inside and is_digest):
                message = (
                    f"files of {found.named!r}: {path!r} must be a relative path without '..', "
                )
                message += f"with a sha256 of {_NUM_DIGITS} hexadecimal digits, got {sha256!r}"
                raise SceneInvalid(message, {"path": "files"})
        for path in (found.main, found.card):
            if path and path not in found.sha256:
                message = f"files of {found.named!r}: {path!r} is not among {sorted(found.sha256)}"
                raise SceneInvalid(message, {"path": "files"})
        return found
