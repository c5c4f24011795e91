"""validate_obj(): validation of an OBJ's face indices and vertices before Drake parses it.

Drake reads vertices out of bounds, which ends the process, and accepts NaN as a position.
"""

import math
import re
from pathlib import Path

_VERTEX = re.compile(rb"^[ \t]*v[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+(.*)$", re.MULTILINE)


def validate_obj(file: Path) -> None:
    """Raise unless an OBJ has every vertex that its faces name, and all at finite positions.

    Raises:
        ValueError: It does not; the message names the vertex or face, counted from 1.
    """
    content = file.read_bytes()
    count = 0
    for vertex in _VERTEX.finditer(content):
        count += 1
        if not all(map(_is_finite, vertex.groups())):
            text = b" ".join(vertex.groups())[:80].decode("utf-8", "replace")
            message = f"vertex {count} has coordinates that are not finite: {text}"
            raise ValueError(message)
    for number, face in enumerate(_FACE.finditer(content), 1):
        for word in face[1].split():
            index = word.partition(b"/")[0]
            # Negative ones count back from the last vertex so far; Drake refuses words that are no
            # numbers.
            if index.isdigit() and int(index) > count:
                message = f"face {number} names vertex {int(index)}, but there are {count} vertices"
                raise ValueError(message)


def _is_finite(word: bytes) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return True  # Drake itself refuses words that are no numbers
