"""JSON texts: how payloads, results and events are kept and sent."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import TypeAdapter

_ANY: TypeAdapter[Any] = TypeAdapter(Any)
_SCALARS = frozenset({float, int, str, bool, type(None)})
_NAMES = frozenset({str})


@dataclass(frozen=True)
class Encoded:
    """Content that is JSON text already, so that nobody decodes it only to encode it again."""

    text: str


def encode(content: Any) -> str:
    """Return the JSON text of content; numbers that JSON cannot hold become null.

    Floats come back bit for bit. The text is ASCII, so every database can hold it.

    Raises:
        TypeError: Something in it is not JSON-compatible.
        ValueError: It contains itself.
    """
    try:
        return json.dumps(content, allow_nan=False, separators=(",", ":"))
    except ValueError as fault:
        if "Circular" in str(fault):
            raise
        return json.dumps(_finite(content), allow_nan=False, separators=(",", ":"))


def encode_result(content: Any) -> str:
    """Return a text that says what that of `encode` does, a few times faster if content is large.

    Raises:
        TypeError: Something in it is not JSON-compatible.
        ValueError: It contains itself.
    """
    try:
        if _is_plain(content):  # the faster encoder would take sets, bytes and instants as well
            return _ANY.dump_json(content, ensure_ascii=True).decode("ascii")
    except (ValueError, RecursionError):  # halves of characters; what has to be refused
        pass
    return encode(content)


def encode_leniently(content: Any) -> str:
    """Return the JSON text of content; what is not JSON-compatible is shown as Python shows it."""
    try:
        return encode(content)
    except (TypeError, ValueError, RecursionError):
        return json.dumps({"shown": repr(content)[:2000]})


def _is_plain(content: Any) -> bool:
    """Return whether content is made of JSON's own kinds, and nothing derived from them."""
    kind = type(content)
    if kind is list or kind is tuple:
        items = content
    elif kind is dict:
        if not _NAMES.issuperset(map(type, content)):
            return False
        items = content.values()
    else:
        return kind in _SCALARS
    # Mostly they are numbers, and then none is looked at in Python.
    return _SCALARS.issuperset(map(type, items)) or all(map(_is_plain, items))


def _finite(content: Any) -> Any:
    match content:
        case float() if not math.isfinite(content):
            return None
        case Mapping():
            return {key: _finite(item) for key, item in content.items()}
        case list() | tuple():
            return [_finite(item) for item in content]
        case _:
            return content
