"""Models of answers: pydantic classes, and unions by the member that tells them apart."""

from typing import Any

from client.generator.annotations import Annotations, class_name, docstring, is_class, literal
from client.generator.document import Document, Schema

# Classes by hand that a model has what no document says from.
_BASES = {"Plan": "ShownPlan"}
_HEAD = '''"""What a server answers. Made by `python -m client.generator`: never edit it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field, Json

from wayproof_client.answer import Answer
from wayproof_client.shown_plan import ShownPlan
'''
_OF = Annotations(is_answer=True)


def models_text(document: Document) -> str:
    """Return the module of all answers."""
    parts = [_HEAD]
    for name in document.answered():
        schema = document.schemas[name]
        parts.append(_class(name, schema) if is_class(schema) else _alias(document, name, schema))
    return "\n\n".join(parts) + "\n"


def _class(name: str, schema: Schema) -> str:
    base = _BASES.get(name, "Answer")
    lines = [f"class {class_name(name)}({base}):", docstring(schema.get("description", name)), ""]
    required = set(schema.get("required", ()))
    for member, said in sorted(
        schema["properties"].items(), key=lambda item: item[0] not in required
    ):
        lines.append(f"    {_member(member, said, is_required=member in required)}")
        if "description" in said:
            lines.append(docstring(said["description"]))
    return "\n".join(lines)


def _member(name: str, schema: Schema, *, is_required: bool) -> str:
    annotation = _OF.of(schema)
    if is_required:
        return f"{name}: {annotation}"
    value = schema.get("default")
    if value is None and "None" not in annotation.split(" | "):
        annotation += " | None"
    if isinstance(value, dict | list):
        # Answers are checked once: a default is checked as well, so that it has its class.
        return f"{name}: {annotation} = Field(default={value!r}, validate_default=True)"
    return f"{name}: {annotation} = {literal(value)}"


def _alias(document: Document, name: str, schema: Schema) -> str:
    key = schema.get("discriminator", {}).get("propertyName")
    if key is None:
        return _told(f"type {class_name(name)} = {_OF.of(schema)}", schema)
    other = f"Other{class_name(name)}"
    named = [one["$ref"].rsplit("/", 1)[-1] for one in schema["oneOf"]]
    known = [one for one in named if one != other]
    classes = [document.schemas[one] for one in known]
    annotation = " | ".join(map(class_name, known))
    union = f"Annotated[{annotation}, Field(discriminator={literal(key)})]"
    in_order = 'Field(union_mode="left_to_right")'
    told = _told(f"type {class_name(name)} = Annotated[{union} | {other}, {in_order}]", schema)
    if other in document.schemas:
        return told
    return f"{_other(other, key, classes)}\n\n\n{told}"


def _other(name: str, key: str, classes: list[Schema]) -> str:
    """Return a class of what a newer server has beside the classes of a union."""
    shared = set.intersection(*(set(schema["properties"]) for schema in classes)) - {key}
    lines = [f"class {name}(Answer):", docstring("One that a newer server has."), ""]
    lines.append(f"    {key}: str")
    for member in sorted(shared):
        kinds = {_OF.of(schema["properties"][member]) for schema in classes}
        is_required = all(member in schema.get("required", ()) for schema in classes)
        kind = kinds.pop() if len(kinds) == 1 else "Any"
        if kind.startswith("Json["):
            kind = "Json[Any]"
        lines.append(f"    {member}: {kind if is_required else f'{kind} | None = None'}")
    return "\n".join(lines)


def _told(alias: str, schema: Any) -> str:
    return f"{alias}\n{docstring(schema['description'], '')}" if "description" in schema else alias
