"""summary(): an answer short enough to be committed: what is long in it is a digest."""

import hashlib
import json
from typing import Any

# The most characters of a body that is kept whole, and of a part of a longer one.
WHOLE = 2000
PART = 250
# The most items of a list whose long items are shortened one by one.
FEW = 10


def summary(body: Any) -> Any:
    """Return a body, or where it is long what of it is short, and digests of the rest."""
    return body if len(_text(body)) <= WHOLE else _shortened(body)


def _shortened(part: Any) -> Any:
    text = _text(part)
    if len(text) <= PART:
        return part
    if isinstance(part, dict):
        return {key: _shortened(inner) for key, inner in part.items()}
    if isinstance(part, list) and _has_few_long_items(part):
        return [_shortened(inner) for inner in part]
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    items = {"items": len(part), "made_of": shape(part)} if isinstance(part, list) else {}
    return {"<digest>": digest, **items}


def _has_few_long_items(part: list[Any]) -> bool:
    return len(part) <= FEW and all(len(_text(inner)) > PART for inner in part)


def shape(part: Any) -> Any:
    """Return the types in a value, each list with one of each kind of its items."""
    if isinstance(part, dict):
        return {key: shape(part[key]) for key in sorted(part)}
    if isinstance(part, list):
        kinds: list[Any] = []
        for inner in part:
            if (kind := shape(inner)) not in kinds:
                kinds.append(kind)
        return kinds
    return "null" if part is None else type(part).__name__


def _text(part: Any) -> str:
    return json.dumps(part, sort_keys=True)
