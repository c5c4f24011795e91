"""included_models(): the descriptions that an SDF includes, directly or through others."""

import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

from planning.errors import ModelInvalid
from planning.world.documents.xml_file import xml_root

_IN_PACKAGE = re.compile(r"^(?:package|model)://([^/]+)/?(.*)$")
_MAX_INCLUDES = 200


def included_models(file: Path, root: ET.Element, packages: Mapping[str, Path]) -> list[ET.Element]:
    """Return the roots of all included descriptions; missing ones are left to Drake's error.

    Args:
        file: The SDF.
        root: Its root element.
        packages: Folders of the packages that Drake has.

    Raises:
        ModelInvalid: A file includes itself, directly or through others, or too many are included.
    """
    found: list[ET.Element] = []
    pending: list[tuple[tuple[Path, ...], ET.Element]] = [((file.resolve(),), root)]
    while pending:
        chain, current = pending.pop()
        for uri in current.iterfind(".//include/uri"):
            path = _model_at((uri.text or "").strip(), chain[-1].parent, packages)
            inner = None if path is None else _root_of(path)
            if path is None or inner is None:
                continue
            path = path.resolve()
            if path in chain:
                cycle = " -> ".join(step.name for step in (*chain[chain.index(path) :], path))
                raise _invalid(file, f"it includes itself: {cycle}")
            found.append(inner)
            pending.append(((*chain, path), inner))
            if len(found) > _MAX_INCLUDES:
                raise _invalid(file, f"more than {_MAX_INCLUDES} descriptions are included")
    return found


def _root_of(path: Path) -> ET.Element | None:
    try:
        return xml_root(path.read_bytes())
    except (ValueError, OSError):
        return None  # Drake reports it


def _invalid(file: Path, reason: str) -> ModelInvalid:
    return ModelInvalid(f"{file.name}: {reason}", {"file": str(file), "reason": reason})


def _model_at(uri: str, folder: Path, packages: Mapping[str, Path]) -> Path | None:
    match = _IN_PACKAGE.match(uri)
    if match is None:
        path = folder / uri.removeprefix("file://")
    elif match[1] in packages:
        path = packages[match[1]] / match[2]
    else:
        return None
    if path.is_dir():
        return next(iter(sorted(path.glob("*.sdf"))), None)
    return path if path.is_file() else None
