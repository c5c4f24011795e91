"""Numbers on the wire: finite, never text, never booleans; 1.0 is an integer, as JSON has it."""

from typing import Annotated, Any

from pydantic import AllowInfNan, BeforeValidator, Field, Strict


def integral(number: Any) -> Any:
    """Turn 3.0 into 3: JSON knows one kind of number."""
    is_whole = isinstance(number, float) and number.is_integer()
    return int(number) if is_whole else number


# Last in an `Annotated`, so that bounds before it stay bounds of the number.
WHOLE = BeforeValidator(integral)

type Integer = Annotated[int, Strict(), WHOLE]
type Real = Annotated[float, Strict(), AllowInfNan(allow_inf_nan=False)]
type Coordinate = Annotated[
    float, Strict(), AllowInfNan(allow_inf_nan=False), Field(ge=-1e6, le=1e6)
]
type NonNegative = Annotated[float, Strict(), AllowInfNan(allow_inf_nan=False), Field(ge=0, le=1e6)]
type Scale = Annotated[float, Strict(), AllowInfNan(allow_inf_nan=False), Field(gt=0, le=1)]
type Triple = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
type Quadruple = Annotated[list[Coordinate], Field(min_length=4, max_length=4)]
type Positions = Annotated[list[Coordinate], Field(min_length=1, max_length=256)]
