"""The artifact of a scene: its document, and what the files are that it was made from."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from service.jobs.artifacts import Artifact
from service.jobs.host_folder import artifact_path
from service.jobs.json_text import Encoded, decode_parts, encode_in_parts
from service.scenes.tasks import LoadedScene

_DOCUMENT = "document"


def artifact_of(loaded: LoadedScene) -> Artifact:
    """Return the artifact of a scene that was loaded; its parts are the files."""
    files = loaded.summary.files
    plain = None if files is None else {name: kept.model_dump() for name, kept in files.items()}
    text = encode_in_parts({"files": plain, _DOCUMENT: loaded.document})
    kept = [] if files is None else files.values()
    parts = sorted({sha256 for each in kept for sha256 in each.sha256.values()})
    return Artifact(text.encode(), tuple(parts))


def document_of(content: bytes) -> Encoded:
    """Return the document that an artifact has; it is not read."""
    document = decode_parts(content.decode())[_DOCUMENT]
    assert isinstance(document, Encoded)  # noqa: S101  (so it was written)
    return document


def files_of(content: bytes) -> Mapping[str, Mapping[str, Any]]:
    """Return what the files of a scene are, by robot and object; nothing if it has none.

    Args:
        content: Of an artifact: a scene's, or another one.
    """
    first, is_first_line, _ = content.partition(b"\n")
    try:
        # A file of version 0.1 is one line; else the document is on the second one.
        found = json.loads(first.rstrip(b",") + b"}" if is_first_line else first)
        return found.get("files") or {}
    except (ValueError, AttributeError):
        return {}


def part_of(folder: Path, digest: str) -> Artifact:
    """Return the file of a digest, which the worker that loaded a scene has copied.

    Raises:
        OSError: It cannot be read.
    """
    return Artifact(artifact_path(folder, digest).read_bytes())
