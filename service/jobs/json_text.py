"""JSON texts: how payloads, results and events are kept and sent."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic_core import to_json


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
    """Return what `encode` does, a few times faster, of what a task gives: members have names.

    What only Python can tell from lists and strings (sets, bytes, instants) is not refused.

    Raises:
        TypeError: Something in it is not JSON-compatible.
        ValueError: It contains itself.
    """
    try:
        return to_json(content, inf_nan_mode="null", ensure_ascii=True).decode("ascii")
    except ValueError:  # halves of characters, or what has to be refused with a reason
        return encode(content)


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
