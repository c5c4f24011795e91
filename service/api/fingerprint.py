"""fingerprint(): what an idempotency key stands for, the same in all versions of this program.

A key of an older version still names its job after an update: a field that was added since counts
only where it says something else than its default, which is what the older version did.
"""

from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo


class _Added:
    """Marks a field that version 0.1 did not have."""


# In the `Annotated` of every field that is added to a request.
ADDED = _Added()


def fingerprint(request: BaseModel) -> dict[str, Any]:
    """Return what a request says (JSON), without added fields that have their defaults."""
    return _said(request, request.model_dump(mode="json"))


def _said(content: Any, dumped: Any) -> Any:
    match content:
        case BaseModel():
            kept = {
                name: field
                for name, field in type(content).model_fields.items()
                if not _is_default(field, getattr(content, name))
            }
            return {name: _said(getattr(content, name), dumped[name]) for name in kept}
        case list():
            return [_said(item, text) for item, text in zip(content, dumped, strict=True)]
        case dict():
            # JSON has keys of text, in the same order.
            pairs = zip(content.values(), dumped.items(), strict=True)
            return {name: _said(item, text) for item, (name, text) in pairs}
        case _:
            return dumped


def _is_default(field: FieldInfo, content: Any) -> bool:
    """Return whether a field was added and has its default."""
    is_added = any(isinstance(mark, _Added) for mark in field.metadata)
    return is_added and bool(content == field.get_default(call_default_factory=True))
