"""Large JSON texts, taken apart and decoded in small steps between which other threads run.

To decode 30 MB at once takes most of a second, in which no other thread of the process runs, and so
the event loop answers nothing. Here strings and brackets alone are looked for, and what they
enclose is decoded in portions.
"""

import json
import re
from collections.abc import Collection, Iterator
from typing import Any

# Takes some milliseconds to decode.
STEP = 256 * 1024
# A string, a list of plain numbers, or a bracket.
_TOKEN = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"|\[[^"\[\]{}]*\]|[\[\]{}]')
# Up to the next bracket that matters, but not so far that it takes long; then perhaps that bracket.
_FLAT = re.compile(
    r'(?:[^"\[\]{}]++|"[^"\\]*+(?:\\.[^"\\]*+)*+"|\[[^"\[\]{}]*+\]){0,1000}+([\[\]{}]?)'
)


def decode(text: str) -> Any:
    """Return what a JSON text says."""
    if len(text) <= STEP:
        return json.loads(text)
    match text[0]:
        case "{":
            return {name: decode(part) for name, part in members_of(text)}
        case "[":
            found: list[Any] = []
            for portion in _portions(text):
                found += json.loads(f"[{portion}]")
            return found
        case _:
            return json.loads(text)


def member_of(text: str, wanted: str) -> str | None:
    """Return the text of a member of an object, None if it has none of that name."""
    # `encode_in_parts` gives what is large a line of its own, which is found without reading.
    before = f"\n{json.dumps(wanted)}:"
    at = text.find(before)
    if at < 0:
        return next((part for name, part in members_of(text) if name == wanted), None)
    begin = at + len(before)
    end = text.find("\n", begin)
    return text[begin : (len(text) if end < 0 else end) - 1]


def ends_of(text: str) -> list[Any]:
    """Return the first and the last element of a list of numbers, or of lists of numbers."""
    inner = text.strip()[1:-1].strip()
    if not inner:
        return []
    if inner[0] == "[":
        return [json.loads(inner[: inner.index("]") + 1]), json.loads(inner[inner.rindex("[") :])]
    return [json.loads(inner.split(",", 1)[0]), json.loads(inner.rsplit(",", 1)[-1])]


def without_members(text: str, names: Collection[str]) -> str:
    """Return the text of an object without the members of some names; what stays is not read."""
    kept = [f"{json.dumps(name)}:{part}" for name, part in members_of(text) if name not in names]
    return f"{{{','.join(kept)}}}"


def members_of(text: str) -> Iterator[tuple[str, str]]:
    """Yield names and texts of an object's members, in order.

    Args:
        text: Of a JSON object.
    """
    name, begin, at = "", 0, 1
    while (token := _TOKEN.search(text, at)) is not None:
        start, at = token.span()
        if text[start] == '"' and text[at : at + 1] == ":":
            if begin:
                yield name, text[begin:start].rstrip(", \n")
            name, begin = json.loads(token[0]), at + 1
        elif text[start] == "}":
            if begin:
                yield name, text[begin:start].rstrip()
            return
        elif at - start == 1:
            at = _after(text, at)


def _after(text: str, at: int) -> int:
    """Return where what has just been opened by a bracket has been closed."""
    depth = 1
    while depth:
        found = _FLAT.match(text, at)
        assert found is not None  # noqa: S101  (it matches nothing as well)
        if found.end() == at:
            message = "a bracket is not closed"
            raise ValueError(message)
        at = found.end()
        if found[1]:
            depth += 1 if found[1] in "[{" else -1
    return at


def _portions(text: str) -> Iterator[str]:
    """Yield the elements of a list, some at a time, without the brackets around them."""
    begin, depth, end = 1, 0, text.rindex("]")
    first = _TOKEN.match(text)
    if first is not None and first.end() == end + 1:  # plain numbers
        while begin < end:
            cut = text.find(",", begin + STEP)
            cut = end if cut < 0 else cut
            yield text[begin:cut]
            begin = cut + 1
        return
    for token in _TOKEN.finditer(text):
        start, after = token.span()
        if text[start] != '"' and after - start == 1:
            depth += 1 if text[start] in "[{" else -1
        if depth == 1 and after - begin > STEP and text[after : after + 1] == ",":
            yield text[begin:after]
            begin = after + 1
    if text[begin:end].strip():
        yield text[begin:end]
