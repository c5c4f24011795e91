"""Annotations: what a schema is in Python."""

import json
import re
from typing import TYPE_CHECKING, Any

from client.generator.document import Schema

if TYPE_CHECKING:
    from collections.abc import Callable

_SCALARS = {
    "string": "str",
    "integer": "int",
    "number": "float",
    "boolean": "bool",
    "null": "None",
}


class Annotations:
    """Turns schemas into annotations, either for requests or for answers."""

    def __init__(self, *, is_answer: bool, prefix: str = "") -> None:
        """Choose a direction.

        Args:
            is_answer: A newer server may have new names where this document has an enumeration,
                and times are parsed. Requests keep to what is written.
            prefix: In front of names of schemas, as `models.`.
        """
        self._is_answer = is_answer
        self._prefix = prefix

    def of(self, schema: Schema) -> str:
        """Return the annotation of a schema."""
        ways: tuple[tuple[str, Callable[[Any], str]], ...] = (
            ("$ref", self._name),
            ("anyOf", self._union),
            ("oneOf", self._union),
            ("const", self._literal_of_one),
            ("enum", self._literals),
            ("contentSchema", self._json),
            ("prefixItems", self._tuple),
        )
        for key, way in ways:
            if key in schema:
                return way(schema[key])
        return self._plain(schema)

    def _name(self, reference: str) -> str:
        return self._prefix + class_name(reference.rsplit("/", 1)[-1])

    def _union(self, schemas: list[Schema]) -> str:
        return " | ".join(dict.fromkeys(self.of(schema) for schema in schemas))

    def _literal_of_one(self, value: Any) -> str:
        return f"Literal[{literal(value)}]"

    def _literals(self, values: list[Any]) -> str:
        known = f"Literal[{', '.join(literal(value) for value in values)}]"
        return f"{known} | str" if self._is_answer else known

    def _json(self, schema: Schema) -> str:
        return f"Json[{self.of(schema)}]"

    def _tuple(self, schemas: list[Schema]) -> str:
        parts = [self.of(schema) for schema in schemas]
        if self._is_answer:
            return f"tuple[{', '.join(parts)}]"
        return f"Sequence[{' | '.join(dict.fromkeys(parts))}]"

    def _plain(self, schema: Schema) -> str:
        match schema.get("type"):
            case "array":
                many = "list" if self._is_answer else "Sequence"
                return f"{many}[{self.of(schema.get('items', {}))}]"
            case "object":
                values = schema.get("additionalProperties")
                inner = self.of(values) if isinstance(values, dict) else "Any"
                return f"{'dict' if self._is_answer else 'Mapping'}[str, {inner}]"
            case "string" if self._is_answer and schema.get("format") == "date-time":
                return "datetime"
            case str() as scalar:
                return _SCALARS[scalar]
            case _:
                return "Any"


def class_name(name: str) -> str:
    """Return the name of a class for a schema."""
    return re.sub(r"\W", "", name)


def is_class(schema: Schema) -> bool:
    """Return whether a schema has members of its own, rather than being a name for a type."""
    return schema.get("type") == "object" and "properties" in schema


def literal(value: Any) -> str:
    """Return a value as Python writes it, with double quotes."""
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def snake(name: str) -> str:
    """Return a name in camel case, or with hyphens, as Python has it."""
    return re.sub(r"(?<=[a-z0-9])([A-Z])", r"_\1", name).replace("-", "_").lower()


def docstring(text: str, indent: str = "    ") -> str:
    """Return a docstring, wrapped at 100 characters; its first line is a sentence."""
    words = text.replace("\\", "\\\\").replace('"""', "'''").split()
    lines, line = [], indent + '"""'
    for word in words:
        if len(line) + 1 + len(word) > 96:
            lines.append(line)
            line = indent + word
        else:
            line += word if line.endswith('"""') else f" {word}"
    end = "" if line.rstrip().endswith((".", "?", "!", "`.")) else "."
    return "\n".join([*lines, f'{line}{end}"""'])
