"""Texts of which all values are known: the document lists them, and what is answered is not judged.

Older versions stored other values, and newer ones may: an answer passes on what was recorded.
"""

from collections.abc import Iterable
from enum import StrEnum
from typing import Annotated, cast

from pydantic import GetJsonSchemaHandler, TypeAdapter
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema


class OneOf:
    """Mark of a text whose values the OpenAPI document lists, under a name of their own."""

    def __init__(self, name: str, doc: str, values: Iterable[str]) -> None:
        """Remember the values that this version answers with; the empty text is `NONE`."""
        members = {value.upper() or "NONE": value for value in values}
        self._enum = cast("type[StrEnum]", StrEnum(name, members))
        self._enum.__doc__ = doc

    def __get_pydantic_json_schema__(
        self, _: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of the values."""
        # Only parts of a schema become references.
        known = TypeAdapter(self._enum).core_schema
        return handler(core_schema.list_schema(known))["items"]


class Matching:
    """Mark of a text of known words, some with a name behind them: the document has a pattern."""

    def __init__(self, words: Iterable[str], named: Iterable[str]) -> None:
        """Remember what stands alone, and the expressions of what a name follows."""
        self.pattern = f"^({'|'.join([*words, *(f'{word} .+' for word in named)])})$"

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of texts that match."""
        return {**handler(schema), "pattern": self.pattern}


# In the order in which a job goes through them, each where it has them; see `timings`.
STAGES = (
    "load",
    "goals",
    "line",
    "roadmap",
    "search",
    "refine",
    "retime",
    "schedule",
    "certify",
    "explain",
    "samples",
    "regions",
    "execute",
)
# Of what failed where no stage explains it: the whole plan, or the worker.
NO_STAGE = ("", "plan", "worker")

Stage = Annotated[str, OneOf("Stage", "Stages of jobs.", STAGES)]
AnyStage = Annotated[
    str,
    OneOf("AnyStage", "Stages of jobs, and what stands for none.", (*STAGES, *NO_STAGE)),
]
