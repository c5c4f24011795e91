"""decode_json(): JSON in which no object has a key twice."""

import json
from collections import Counter
from collections.abc import Iterator
from typing import Any

from planning.world.documents.document_faults import Fault


class RepeatedKey(Exception):
    """An object has a key twice, and JSON would keep the last one.

    Attributes:
        fault: Where, and which.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(fault.message)
        self.fault = fault


class _Twice(dict[str, Any]):
    """An object with a key that was given twice."""

    key: str = ""


def decode_json(text: str | bytes) -> Any:
    """Return what a JSON text says.

    Raises:
        ValueError: It is not JSON.
        RecursionError: It is nested too deeply.
        RepeatedKey: An object has a key twice.
    """
    found: list[_Twice] = []

    def built(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        plain = dict(pairs)
        if len(plain) == len(pairs):
            return plain
        twice = _Twice(plain)
        twice.key = next(key for key, n in Counter(key for key, _ in pairs).items() if n > 1)
        found.append(twice)
        return twice

    document = json.loads(text, object_pairs_hook=built)
    for steps, part in _parts(document) if found else ():
        if isinstance(part, _Twice):
            message = f"key {part.key[:80]!r} is given twice"
            raise RepeatedKey(Fault((*steps, part.key), message, "repeated_key"))
    if found:  # inside a value that another one of the same key has replaced
        message = f"key {found[-1].key[:80]!r} is given twice"
        raise RepeatedKey(Fault((found[-1].key,), message, "repeated_key"))
    return document


def _parts(document: Any) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Yield every part of a document with its steps, the outer ones first."""
    pending: list[tuple[tuple[str | int, ...], Any]] = [((), document)]
    while pending:
        steps, part = pending.pop()
        yield steps, part
        if isinstance(part, dict):
            pending += [((*steps, key), child) for key, child in part.items()]
        elif isinstance(part, list):
            pending += [((*steps, i), child) for i, child in enumerate(part)]
