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
    """Return the roots of all included descriptions.

    A missing one is refused here: Drake's parser would look for it from the working folder of the
    process, and leave out what it finds there and cannot read.

    Args:
        file: The SDF.
        root: Its root element.
        packages: Folders of the packages that Drake has.

    Raises:
        ModelInvalid: A file includes itself, directly or through others, or what is no description,
            or too many are included.
    """
    found: list[ET.Element] = []
    pending: list[tuple[tuple[Path, ...], ET.Element]] = [((file.resolve(),), root)]
    while pending:
        chain, current = pending.pop()
        for uri in current.iterfind(".//include/uri"):
            named = (uri.text or "").strip()
            path = _model_at(named, chain[-1].parent, packages)
            if path is None:
                raise _invalid(file, f"it includes {named!r}, which does not exist")
            inner, path = _root_of(file, named, path), path.resolve()
            if path in chain:
                cycle = " -> ".join(step.name for step in (*chain[chain.index(path) :], path))
                raise _invalid(file, f"it includes itself: {cycle}")
            found.append(inner)
            pending.append(((*chain, path), inner))
            if len(found) > _MAX_INCLUDES:
                raise _invalid(file, f"more than {_MAX_INCLUDES} descriptions are included")
    return found


def _root_of(file: Path, named: str, path: Path) -> ET.Element:
    try:
        return xml_root(path.read_bytes())
    except (ValueError, OSError) as fault:
        raise _invalid(file, f"it includes {named!r}, which is no description: {fault}") from fault


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
