"""StrictModel: base of documents without unknown keys, NaN, or quoted values other than text."""

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict


def _reject_non_numbers(number: Any) -> Any:
    """Raise on values that float() would convert: booleans and text."""
    if isinstance(number, bool | str | bytes):
        message = f"a number is required, got {number!r}"
        raise ValueError(message)  # noqa: TRY004  (pydantic collects ValueErrors)
    return number


type Number = Annotated[
    float, BeforeValidator(_reject_non_numbers), Field(allow_inf_nan=False), Field(ge=-1e6, le=1e6)
]
type Positive = Annotated[
    float, BeforeValidator(_reject_non_numbers), Field(allow_inf_nan=False), Field(ge=1e-6, le=1e4)
]
type Distance = Annotated[
    float, BeforeValidator(_reject_non_numbers), Field(allow_inf_nan=False), Field(ge=0, le=10)
]
type Unit = Annotated[
    float, BeforeValidator(_reject_non_numbers), Field(allow_inf_nan=False), Field(ge=0, le=1)
]
type Boolean = Annotated[bool, Strict()]


class StrictModel(BaseModel):
    """Immutable document without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)
