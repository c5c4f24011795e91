"""validate_vtk(): validation of a VTK file's cells and points (legacy format, ASCII).

VTK reads points out of bounds, and allocates whatever memory the file announces.
"""

from pathlib import Path

import numpy as np


def validate_vtk(file: Path) -> None:
    """Raise unless a VTK file has every point that its cells name, and all at finite positions.

    Raises:
        ValueError: It does not, or is not written as text; the message names the list.
    """
    words = file.read_bytes().split()
    if b"BINARY" in words[:20]:
        message = "it is BINARY, which cannot be validated before it is parsed: write it as ASCII"
        raise ValueError(message)
    if b"POINTS" not in words or b"CELLS" not in words:
        return  # Drake refuses any other kind
    count, points = _announced_list(words, b"POINTS", 3)
    if not np.isfinite(_numbers(points[:], np.float64, "POINTS")).all():
        message = "POINTS: one has coordinates that are not finite"
        raise ValueError(message)
    for k, index in enumerate(_connectivity(words)):
        if not 0 <= index < count:
            message = f"CELLS: number {k} in the list is point {index}, but there are {count}"
            raise ValueError(message)


def _announced_list(words: list[bytes], name: bytes, per_item: int) -> tuple[int, list[bytes]]:
    """Return the length that a list announces, and its words after `name n type`."""
    at = words.index(name)
    count = int(_numbers(words[at + 1 : at + 2], np.int64, name.decode())[0])
    found = words[at + 3 : at + 3 + per_item * count] if count >= 0 else []
    if len(found) < per_item * count or count < 1:
        message = f"{name.decode()}: {count} are announced, but {len(found) // per_item} follow"
        raise ValueError(message)
    return count, found


def _connectivity(words: list[bytes]) -> list[int]:
    """Return the point indices of all cells; with counts between them, or since 5.1 without."""
    if b"CONNECTIVITY" in words:
        at = words.index(b"CONNECTIVITY") + 2
        stop = next((k for k in range(at, len(words)) if not _is_integer(words[k])), len(words))
        return _numbers(words[at:stop], np.int64, "CONNECTIVITY").tolist()
    at = words.index(b"CELLS")
    cells, size = _numbers(words[at + 1 : at + 3], np.int64, "CELLS").tolist()
    listed = _numbers(words[at + 3 : at + 3 + size], np.int64, "CELLS").tolist()
    if len(listed) < size or cells < 1:
        message = f"CELLS: {size} numbers are announced, but {len(listed)} follow"
        raise ValueError(message)
    found: list[int] = []
    index = 0
    for _ in range(cells):
        if index >= size or index + listed[index] >= size or listed[index] < 1:
            message = f"CELLS: {cells} are announced, but fewer follow"
            raise ValueError(message)
        found += listed[index + 1 : index + 1 + listed[index]]
        index += 1 + listed[index]
    return found


def _is_integer(word: bytes) -> bool:
    return word.removeprefix(b"-").isdigit()


def _numbers(words: list[bytes], kind: type, name: str) -> np.ndarray:
    try:
        return np.array(words).astype(kind)
    except (ValueError, OverflowError) as fault:
        message = f"{name}: {str(fault)[:100]}"
        raise ValueError(message) from fault
