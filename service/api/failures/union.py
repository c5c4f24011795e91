"""Unions by `code` in the OpenAPI document, whose values are one model with evidence as it came.

Evidence may be megabytes, and older versions stored other codes and members: what is answered is
not validated again. The document says what it is, and the tests compare the two.
"""

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import Any, Literal, cast, override

from pydantic import BaseModel, Field, GetJsonSchemaHandler, TypeAdapter, create_model
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from planning.errors import WayproofError

# By code, and the one for every other code.
type UnionMembers = tuple[Mapping[str, type[BaseModel]], type[BaseModel]]


def enum_of(name: str, doc: str, codes: Iterable[str]) -> type[StrEnum]:
    """Return the enum of some codes."""
    members = {code.upper(): code for code in sorted(codes)}
    made = cast("type[StrEnum]", StrEnum(name, members))
    made.__doc__ = doc
    return made


class NoneOf:
    """Mark of a text that is none of an enum's."""

    def __init__(self, enum: type[StrEnum]) -> None:
        """Remember the enum."""
        self._enum = TypeAdapter(enum)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of a text without the enum's."""
        known = handler(core_schema.list_schema(self._enum.core_schema))["items"]
        return {**handler(schema), "not": known}


def member[M: BaseModel](
    base: type[M], error: type[WayproofError] | None, code: str, evidence: Any
) -> type[M]:
    """Return the type of a failure or a problem with one code.

    Args:
        base: Of all of them; its name ends the name of the member.
        error: Whose documentation says what happened; None for a code without an error of ours.
        code: The code.
        evidence: Type of the evidence.
    """
    name = f"{''.join(word.capitalize() for word in code.split('_'))}{base.__name__}"
    doc = meaning(error) if error else "Any other status."
    literal: Any = Literal[code]  # pyright: ignore[reportInvalidTypeForm]
    fields: dict[str, Any] = {
        "code": (literal, Field(description="Stable machine-readable name of the kind")),
        "evidence": (evidence, Field(description="Facts behind it [SI units, radians]")),
    }
    return create_model(name, __base__=base, __doc__=doc, **fields)


def meaning(error: type[WayproofError]) -> str:
    """Return what an error means: the first sentence of its documentation, without evidence."""
    first = " ".join((error.__doc__ or "").split("\n\n")[0].split())
    return f"{first.partition('; evidence')[0].removesuffix('.')}."


class CodedUnion(BaseModel):
    """A model that stands for all members of a union by `code`, and is the base of each."""

    @classmethod
    @abstractmethod
    def union_members(cls) -> UnionMembers:
        """Return the members by code, and the one for every other code."""

    @classmethod
    @override
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the union for the model itself, and for a member its own schema."""
        schema = handler.resolve_ref_schema(handler(core_schema))
        if CodedUnion not in cls.__bases__:
            return {key: part for key, part in schema.items() if key != "examples"}
        return _union_schema(schema, *cls.union_members(), handler)


def _union_schema(
    whole: JsonSchemaValue,
    members: Mapping[str, type[BaseModel]],
    other: type[BaseModel],
    handler: GetJsonSchemaHandler,
) -> JsonSchemaValue:
    """Return the schema of a union by `code`.

    Args:
        whole: Schema of the model that stands for all members.
        members: By code.
        other: The member for every other code.
        handler: Of the schema that this is a part of.
    """
    choices = {code: kind.__pydantic_core_schema__ for code, kind in members.items()}
    union = handler(core_schema.tagged_union_schema(choices, discriminator="code"))
    # Only parts of a schema become references.
    others = handler(core_schema.list_schema(other.__pydantic_core_schema__))
    kept = {key: whole[key] for key in ("title", "description", "examples") if key in whole}
    return {**kept, **union, "oneOf": [*union["oneOf"], others["items"]]}
