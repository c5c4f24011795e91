"""fields_of(): the fields of a JSON Schema of an OpenAPI document (3.1, as pydantic writes it)."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from service.studio.forms.fields import (
    Choice,
    Field,
    Flag,
    Group,
    Items,
    Number,
    OneOf,
    Optional,
    Text,
    Vector,
    Written,
)

type Schema = Mapping[str, Any]

_LONGEST = 1024
_MOST = 1000


def fields_of(document: Schema, name: str, without: frozenset[str] = frozenset()) -> Group:
    """Return the fields of one of the schemas that a document names.

    Args:
        document: OpenAPI.
        name: Of the schema, below `components/schemas`.
        without: Names of fields that are left out.

    Raises:
        ValueError: It has none.
    """
    found = _Reader(document).read({"$ref": f"#/components/schemas/{name}"}, "")
    if not isinstance(found, Group):
        message = f"{name} is no object with fields"
        raise ValueError(message)  # noqa: TRY004  (of the document, not of an argument)
    return replace(found, fields=tuple(f for f in found.fields if f.name not in without))


def field_of(document: Schema, name: str) -> Field:
    """Return a schema that a document names, as a field without a name."""
    return _Reader(document).read({"$ref": f"#/components/schemas/{name}"}, "")


class _Reader:
    def __init__(self, document: Schema) -> None:
        self._document = document

    def read(self, schema: Schema, name: str, *, is_required: bool = False) -> Field:
        """Return what a schema lets be filled in under a name."""
        default, text = schema.get("default"), schema.get("description", "")
        schema = self._resolved(schema)
        common = name, text or schema.get("description", ""), default, is_required
        if "anyOf" in schema or "oneOf" in schema:
            return self._one_of(schema, common)
        if schema.get("type") == "array":
            return self._array(schema, common)
        if schema.get("properties"):
            return Group(*common, self._properties(schema))
        return _single(schema, common)

    def _resolved(self, schema: Schema) -> Schema:
        while "$ref" in schema:
            found = self._document
            for part in schema["$ref"].removeprefix("#/").split("/"):
                found = found[part]
            schema = found
        return schema

    def _properties(self, schema: Schema) -> tuple[Field, ...]:
        required = schema.get("required", ())
        return tuple(
            _switched(self.read(inner, name, is_required=name in required))
            for name, inner in schema["properties"].items()
        )

    def _array(self, schema: Schema, common: tuple[str, str, Any, bool]) -> Field:
        items = schema.get("items", {})
        inner = self.read(items, "")
        fewest, most = int(schema.get("minItems", 0)), int(schema.get("maxItems", _MOST))
        if isinstance(inner, Number) and fewest == most == 3:
            return Vector(*common, inner.lower, inner.upper, inner.excludes_lower)
        if isinstance(inner, Group) or (isinstance(inner, OneOf) and inner.tag):
            return Items(*common, inner, fewest, most)
        return Written(*common, schema)

    def _one_of(self, schema: Schema, common: tuple[str, str, Any, bool]) -> Field:
        alternatives = list(schema.get("anyOf") or schema["oneOf"])
        others = [one for one in alternatives if one.get("type") != "null"]
        if len(others) < len(alternatives):
            inner = self.read(others[0] if len(others) == 1 else {"anyOf": others}, "")
            named = replace(inner, name=common[0], text=common[1], default=common[2])
            return Optional(*common, named)
        tag = schema.get("discriminator", {}).get("propertyName", "")
        read = [self.read(one, "") for one in others]
        if all(isinstance(field, Written) for field in read):
            return Written(*common, schema)
        named = [replace(_untagged(one, tag), name=_name_of(one, tag)) for one in read]
        return OneOf(*common, tuple(named), tag)


def _single(schema: Schema, common: tuple[str, str, Any, bool]) -> Field:
    """Return a field with one value, or with what is written by hand."""
    options = (schema["const"],) if "const" in schema else tuple(schema.get("enum", ()))
    if options:
        return Choice(*common, options)
    match schema.get("type"):
        case "boolean":
            return Flag(*common)
        case "number" | "integer":
            return Number(*common, *_bounds(schema), is_whole=schema["type"] == "integer")
        case "string":
            return Text(*common, int(schema.get("maxLength", _LONGEST)))
        case _:
            return Written(*common, schema)


def _switched(field: Field) -> Field:
    """Return a group that may be left out, but not its parts, as one that is switched on."""
    if not isinstance(field, Group) or field.is_required or field.default is not None:
        return field
    if not any(inner.is_required for inner in field.fields):
        return field
    return Optional(field.name, field.text, None, is_required=False, inner=field)


def _bounds(schema: Schema) -> tuple[float | None, float | None, bool]:
    lower = schema.get("exclusiveMinimum", schema.get("minimum"))
    return lower, schema.get("maximum"), "exclusiveMinimum" in schema


def _name_of(field: Field, tag: str) -> str:
    """Return what an alternative is called: by its tag, else by what it is."""
    if tag and isinstance(field, Group):
        kind = next(inner for inner in field.fields if inner.name == tag)
        if isinstance(kind, Choice):
            return kind.options[0]
    return "several" if isinstance(field, Written | Items) else "one"


def _untagged(field: Field, tag: str) -> Field:
    if not tag or not isinstance(field, Group):
        return field
    return replace(field, fields=tuple(inner for inner in field.fields if inner.name != tag))
