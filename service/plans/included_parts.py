"""`?include=`: which of the large parts of a plan's result an answer carries.

A plan that is polled need not carry its samples each time. What is small is always there.
"""

from typing import Annotated

from fastapi import Depends, Query

from planning.errors import UnknownName
from service.plans.models.result import LARGE_PARTS

_PART = "|".join(LARGE_PARTS)

type Include = Annotated[
    str | None,
    Query(
        max_length=200,
        description="Large parts of `result` in the answer, with commas between them; by "
        "default all, empty for none. Small parts are always there",
        json_schema_extra={"pattern": f"^(({_PART})(,({_PART}))*)?$"},
        examples=["trajectory,certificate"],
    ),
]


async def _left_out(include: Include = None) -> frozenset[str]:
    return left_out_of(include)


def left_out_of(include: str | None) -> frozenset[str]:
    """Return the large parts that an answer does not carry.

    Raises:
        UnknownName: There is no such part.
    """
    if include is None:
        return frozenset()
    wanted = include.split(",") if include else []
    for name in wanted:
        if name not in LARGE_PARTS:
            raise UnknownName.among("part", name[:80], LARGE_PARTS)
    return frozenset(LARGE_PARTS) - set(wanted)


type LeftOut = Annotated[frozenset[str], Depends(_left_out)]
