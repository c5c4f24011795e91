"""Tables of fields from JSON Schemas: name, type, default and meaning, a heading for each model."""

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

_BOUNDS = {
    "minimum": ">= {}", "exclusiveMinimum": "> {}", "maximum": "<= {}", "exclusiveMaximum": "< {}",
    "minLength": "at least {} characters", "maxLength": "at most {} characters",
    "minItems": "at least {} items", "maxItems": "at most {} items",
}  # fmt: skip
# A default as long as that says less than its place would.
_LONGEST_DEFAULT = 60

_MIXED = ("anyOf", "oneOf", "allOf")

type Schema = Mapping[str, Any]


class SchemaTables:
    """Tables of models, each of which has a heading of its own and so a place to link to.

    Attributes:
        schemas: All models by name; one that is a plain type is shown where it is used.
        shown: Models that have been shown.
    """

    def __init__(self, schemas: Mapping[str, Schema]) -> None:
        """Show nothing yet."""
        self.schemas = schemas
        self.shown: set[str] = set()

    def section(self, root: str) -> str:
        """Return the table of a model and those of all models that it uses and are not shown."""
        parts: list[str] = []
        for name in self._reachable(root):
            if name in self.shown or not self._has_section(name):
                continue
            self.shown.add(name)
            schema = self.schemas[name]
            parts += [f"## {name}", _paragraph(schema.get("description", "")), self._table(schema)]
        return "\n\n".join(filter(None, parts))

    def _has_section(self, name: str) -> bool:
        schema = self.schemas[name]
        return bool({"properties", "enum", "oneOf"} & schema.keys())

    def _reachable(self, root: str) -> list[str]:
        """Return a model and those that it uses, in the order in which they are met."""
        found = [root]
        for name in found:
            found += [each for each in _references(self.schemas[name]) if each not in found]
        return list(dict.fromkeys(found))

    def _table(self, schema: Schema) -> str:
        """Return the fields of a model, or the values of a choice, in Markdown."""
        if "enum" in schema:
            return ", ".join(f"`{value}`" for value in schema["enum"])
        if "properties" not in schema:
            return f"One of: {self._type(schema)}."
        required = schema.get("required", ())
        rows = ["| field | type | default | meaning |", "|---|---|---|---|"]
        for name, field in schema["properties"].items():
            default = "required" if name in required else _default(field)
            described = (cell(field.get("description", "")), _bounds(field))
            meaning = " ".join(filter(None, described))
            rows.append(f"| `{name}` | {cell(self._type(field))} | {default} | {meaning} |")
        return "\n".join(rows)

    def _type(self, field: Schema) -> str:
        if "$ref" in field:
            name = field["$ref"].rpartition("/")[2]
            is_linked = self._has_section(name)
            return f"[{name}](#{name.lower()})" if is_linked else self._type(self.schemas[name])
        values = [field["const"]] if "const" in field else field.get("enum")
        if values:
            return " or ".join(f"`{json.dumps(value)}`" for value in values)
        for joined in _MIXED:
            if joined in field:
                return " or ".join(dict.fromkeys(self._type(each) for each in field[joined]))
        return self._plain_type(field)

    def _plain_type(self, field: Schema) -> str:
        kind = field.get("type", "any")
        if kind == "array" and "prefixItems" in field:
            return f"[{', '.join(self._type(each) for each in field['prefixItems'])}]"
        if kind == "array":
            return f"list of {self._type(field.get('items', {}))}"
        if kind == "object" and isinstance(field.get("additionalProperties"), Mapping):
            return f"object of {self._type(field['additionalProperties'])}"
        return " or ".join(kind) if isinstance(kind, list) else str(kind)


def _default(field: Schema) -> str:
    if "default" not in field:
        return ""
    text = json.dumps(field["default"])
    return f"`{cell(text)}`" if len(text) <= _LONGEST_DEFAULT else "see the model"


def _bounds(field: Schema) -> str:
    found = [
        text.format(each[name])
        for each in (field, *field.get("anyOf", ()))
        for name, text in _BOUNDS.items()
        if name in each
    ]
    return f"({', '.join(found)})" if found else ""


def _references(content: Any) -> Iterator[str]:
    if isinstance(content, Mapping):
        for key, value in content.items():
            if key == "$ref":
                yield value.rpartition("/")[2]
            elif key != "discriminator":
                yield from _references(value)
    elif isinstance(content, list):
        for each in content:
            yield from _references(each)


def _paragraph(text: str) -> str:
    return re.sub(r"\s*\n\s*", " ", text).replace("<", "&lt;")


def cell(text: str) -> str:
    """Return a text as a cell of a table has it."""
    return _paragraph(text).replace("|", "\\|")
