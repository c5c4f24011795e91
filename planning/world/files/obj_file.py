"""require_sound_obj(): whether the faces of an OBJ have their vertices, all at finite places.

Drake reads vertices that are not there, which ends the process, and takes NaN for a position.
"""

import math
import re
from pathlib import Path

_VERTEX = re.compile(rb"^[ \t]*v[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+(.*)$", re.MULTILINE)


def require_sound_obj(file: Path) -> None:
    """Go on only if an OBJ has every vertex that its faces name, and all at finite places.

    Raises:
        ValueError: It does not; the message names the vertex or face, counted from 1.
    """
    content = file.read_bytes()
    count = 0
    for vertex in _VERTEX.finditer(content):
        count += 1
        if not all(map(_is_finite, vertex.groups())):
            message = f"vertex {count} is at {b' '.join(vertex.groups())[:80]!r}, which is no place"
            raise ValueError(message)
    for number, face in enumerate(_FACE.finditer(content), 1):
        for word in face[1].split():
            index = word.partition(b"/")[0]
            # Negative ones count back from the last vertex so far; what is no number Drake refuses.
            if index.isdigit() and int(index) > count:
                message = f"face {number} has vertex {int(index)}, and there are {count} vertices"
                raise ValueError(message)


def _is_finite(word: bytes) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return True  # what is no number Drake refuses itself
