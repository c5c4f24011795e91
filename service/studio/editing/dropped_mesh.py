"""hull_of_file(): the convex hull of an OBJ or STL file that was dropped on the page.

A scene counts a mesh as its convex hull, so nothing is lost for planning. Only the vertices are
read, line by line or as one table, never with a loader of meshes: what a stranger drops makes this
process, which other browsers share, neither wait nor grow beyond a few times the file.
"""

import re
from pathlib import PurePath

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from service.studio.numbers import Array

ENDINGS = (".stl", ".obj")
MAX_BYTES = 32_000_000
_MAX_NAME = 40
# As many points as the server takes of a convex shape.
_MAX_POINTS = 10_000
# Of a binary STL: a header, a count, then facets: a normal, three corners, two bytes.
_HEADER, _FACET = 80, 50
_FACET_TYPE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
# Corners that are the same but for rounding [share of the size].
_SAME = 1e-7


def hull_of_file(name: str, content: bytes, unit: float) -> Array:
    """Return the corners of the convex hull of a file [m], shape (n, 3).

    Args:
        name: Of the file; its ending says what it is.
        content: Of the file.
        unit: Of its numbers [m].

    Raises:
        ValueError: It is too large, or no such file, or it encloses no volume.
    """
    ending = PurePath(name).suffix.lower()
    if ending not in ENDINGS:
        message = f"{name} is none of {', '.join(ENDINGS)}"
        raise ValueError(message)
    if len(content) > MAX_BYTES:
        message = f"{name} has more than {MAX_BYTES // 1_000_000} MB"
        raise ValueError(message)
    try:
        read = _stl_corners(content) if ending == ".stl" else _lines(content, b"v")
    except ValueError as fault:
        message = f"{name} cannot be read: {fault}"
        raise ValueError(message) from fault
    return _hull(name, unit * read)


def name_of_file(name: str) -> str:
    """Return what an object of a file is called: its stem, in letters that names may have."""
    stem = re.sub(r"[^A-Za-z0-9_]+", "_", PurePath(name).stem).strip("_")
    return stem[:_MAX_NAME] or "mesh"


def _stl_corners(content: bytes) -> Array:
    count = int.from_bytes(content[_HEADER : _HEADER + 4], "little")
    if len(content) == _HEADER + 4 + _FACET * count:
        facets = np.frombuffer(content, _FACET_TYPE, count, _HEADER + 4)
        return facets["corners"].reshape(-1, 3).astype(float)
    return _lines(content, b"vertex")


def _lines(content: bytes, word: bytes) -> Array:
    """Return the three numbers behind a word, of each line that begins with it."""
    rows = [
        line.split()[1:4] for line in content.splitlines() if line.lstrip().startswith(word + b" ")
    ]
    if any(len(row) != 3 for row in rows):
        message = f"a line with '{word.decode()}' has not three numbers"
        raise ValueError(message)
    return np.array([[float(part) for part in row] for row in rows]).reshape(-1, 3)


def _hull(name: str, points: Array) -> Array:
    if not np.isfinite(points).all():
        message = f"{name} has numbers that are not finite"
        raise ValueError(message)
    if len(points) < 4:
        message = f"{name} has no solid: {len(points)} corners"
        raise ValueError(message)
    grain = max(_SAME * float(np.ptp(points, axis=0).max()), 1e-12)
    _, rows = np.unique(np.round(points / grain), axis=0, return_index=True)
    try:
        corners = points[rows][ConvexHull(points[rows]).vertices]
    except QhullError as fault:
        message = f"{name} encloses no volume"
        raise ValueError(message) from fault
    if len(corners) > _MAX_POINTS:
        message = f"the convex hull of {name} has {len(corners)} corners: at most {_MAX_POINTS}"
        raise ValueError(message)
    return corners
