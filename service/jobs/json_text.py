"""JSON texts: how payloads, results and events are kept and sent.

Results are written by pydantic; docs/decisions/0086 says why all else is not.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_READER = json.JSONDecoder()


@dataclass(frozen=True)
class Encoded:
    """Content that is JSON text already, so that nobody decodes it only to encode it again."""

    text: str


def decoded(data: Encoded | dict[str, Any]) -> dict[str, Any]:
    """Return an object that may be text still."""
    return json.loads(data.text) if isinstance(data, Encoded) else data


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


def encode_in_parts(content: Mapping[str, Any]) -> str:
    """Return the JSON text of an object, some members of which, but not all, are `Encoded` already.

    It is JSON like any other. Each member that was encoded has a line of its own, which the texts
    themselves never have: `decode_parts` takes the lines apart without reading them.

    Raises:
        TypeError: Something in it is not JSON-compatible.
    """
    parts = {name: part for name, part in content.items() if isinstance(part, Encoded)}
    plain = encode({name: part for name, part in content.items() if name not in parts})
    return with_parts(plain, parts)


def with_parts(plain: str, parts: Mapping[str, Encoded]) -> str:
    """Return the JSON text of an object that has more members, as `encode_in_parts` writes it.

    Args:
        plain: The object without them, which is not empty, as JSON without line feeds.
        parts: The further members.
    """
    lines = [f"{json.dumps(name)}:{part.text}" for name, part in parts.items()]
    return "{" + ",\n".join([plain[1:-1], *lines]) + "}"


def decode_parts(text: str) -> dict[str, Any]:
    """Return what was given to `encode_in_parts`: what was encoded then stays so.

    Raises:
        ValueError: It was encoded in some other way.
    """
    # Nothing else has a line feed, and single characters are found several times as quickly.
    first, *lines = text.split("\n")
    plain: dict[str, Any] = json.loads(f"{first[:-1]}}}")
    for line in lines:
        name, end = _READER.raw_decode(line)
        plain[name] = Encoded(line[end + 1 : -1])
    return plain


def encode_leniently(content: Any) -> str:
    """Return the JSON text of content; what is not JSON-compatible is shown as Python shows it."""
    try:
        return encode(content)
    except (TypeError, ValueError, RecursionError):
        return json.dumps({"shown": repr(content)[:2000]})


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
