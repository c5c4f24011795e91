"""differences(): which parts of two JSON documents differ, by JSON pointer (RFC 6901)."""

from collections.abc import Iterator
from typing import Any


def differences(old: Any, new: Any, pointer: str = "") -> Iterator[tuple[str, str]]:
    """Yield the pointer of each innermost part that differs, and how it does."""
    if isinstance(old, dict) and isinstance(new, dict):
        yield from _of_objects(old, new, pointer)
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield pointer, f"has {len(new)} items, had {len(old)}"
        for i, (before, after) in enumerate(zip(old, new, strict=False)):
            yield from differences(before, after, f"{pointer}/{i}")
    elif old != new or type(old) is not type(new):
        yield pointer, f"is {_short(new)}, was {_short(old)}"


def _of_objects(
    old: dict[str, Any], new: dict[str, Any], pointer: str
) -> Iterator[tuple[str, str]]:
    for key in sorted({*old, *new}):
        inner = f"{pointer}/{_escaped(key)}"
        if key not in new:
            yield inner, f"is gone, was {_short(old[key])}"
        elif key not in old:
            yield inner, f"is new: {_short(new[key])}"
        else:
            yield from differences(old[key], new[key], inner)


def _escaped(key: str) -> str:
    return key.replace("~", "~0").replace("/", "~1")


def _short(part: Any) -> str:
    if isinstance(part, dict):
        return f"an object of {len(part)} members"
    if isinstance(part, list):
        return f"a list of {len(part)}"
    shown = repr(part)
    return shown if len(shown) <= 80 else f"{shown[:77]}..."
