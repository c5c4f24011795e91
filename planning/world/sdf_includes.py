"""included_models(): the descriptions that an SDF includes, and those that they include."""

import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

_IN_PACKAGE = re.compile(r"^(?:package|model)://([^/]+)/?(.*)$")
_DEEPEST = 20


def included_models(
    file: Path, root: ET.Element, packages: Mapping[str, Path], depth: int = _DEEPEST
) -> list[ET.Element]:
    """Return the roots of all included descriptions; Drake says which are not there.

    Args:
        file: The SDF.
        root: Of it.
        packages: Folders of the packages that Drake knows.
        depth: How deep to go on.
    """
    found: list[ET.Element] = []
    for uri in root.iterfind(".//include/uri"):
        path = _model_at((uri.text or "").strip(), file.parent, packages)
        if path is None or depth == 0:
            continue
        try:
            inner = ET.fromstring(path.read_bytes())  # noqa: S314  (Drake reads it as well)
        except (ET.ParseError, ValueError):
            continue
        found += [inner, *included_models(path, inner, packages, depth - 1)]
    return found


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
