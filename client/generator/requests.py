"""Requests: typed dictionaries, so that a type checker checks literals, which cost nothing."""

from client.generator.annotations import Annotations, class_name, docstring, is_class, literal
from client.generator.document import Document, Schema

_HEAD = '''"""What a server is asked. Made by `python -m client.generator`: never edit it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NotRequired, TypedDict
'''
_OF = Annotations(is_answer=False)


def requests_text(document: Document) -> str:
    """Return the module of all requests."""
    parts = [_HEAD]
    for name in document.requested():
        schema = document.schemas[name]
        parts.append(_class(name, schema) if is_class(schema) else _alias(name, schema))
    return "\n\n".join(parts) + "\n"


def _class(name: str, schema: Schema) -> str:
    if not all(member.isidentifier() for member in schema["properties"]):
        return _by_call(name, schema)
    lines = [f"class {class_name(name)}(TypedDict):"]
    lines.append(docstring(schema.get("description", name)))
    lines.append("")
    required = set(schema.get("required", ()))
    for member, said in schema["properties"].items():
        annotation = _OF.of(said)
        kind = annotation if member in required else f"NotRequired[{annotation}]"
        lines.append(f"    {member}: {kind}")
        if "description" in said:
            lines.append(docstring(said["description"]))
    return "\n".join(lines)


def _by_call(name: str, schema: Schema) -> str:
    """Return a typed dictionary whose keys are no names of Python."""
    required = set(schema.get("required", ()))
    members = ", ".join(
        f"{literal(member)}: "
        + (_OF.of(said) if member in required else f"NotRequired[{literal(_OF.of(said))}]")
        for member, said in schema["properties"].items()
    )
    return f"{class_name(name)} = TypedDict({literal(class_name(name))}, {{{members}}})"


def _alias(name: str, schema: Schema) -> str:
    text = f"type {class_name(name)} = {_OF.of(schema)}"
    if "description" in schema:
        text += f"\n{docstring(schema['description'], '')}"
    return text
