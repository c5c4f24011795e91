"""Texts of which all values are known: the document lists them, and what is answered is not judged.

Older versions stored other values, and newer ones may: an answer passes on what was recorded.
"""

from dataclasses import dataclass
from typing import Annotated

from pydantic import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema


@dataclass(frozen=True)
class OneOf:
    """Mark of a text whose values the OpenAPI document lists.

    Attributes:
        values: All that this version answers with.
    """

    values: tuple[str, ...]

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of a text with these values."""
        return {**handler(schema), "enum": list(self.values)}


# In the order in which a job goes through them, each where it has them; see `timings`.
STAGES = (
    "load",
    "goals",
    "line",
    "roadmap",
    "search",
    "refine",
    "retime",
    "certify",
    "explain",
    "samples",
    "regions",
    "execute",
)
# Of what failed where no stage explains it: the whole plan, or the worker.
NO_STAGE = ("", "plan", "worker")

Stage = Annotated[str, OneOf(STAGES)]
AnyStage = Annotated[str, OneOf((*STAGES, *NO_STAGE))]
