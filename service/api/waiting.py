"""How long a client is willing to wait for an answer: `?wait=S`, or `Prefer: wait=S` (RFC 7240)."""

import re
from typing import Annotated

from fastapi import Header, Query

_PREFERENCE = re.compile(r"(?:^|[,;\s])wait\s*=\s*\"?(\d{1,6}(?:\.\d{1,6})?)")

type Wait = Annotated[
    float | None,
    Query(
        ge=0,
        le=3600,
        allow_inf_nan=False,
        description="Answer 200 with the finished job if it ends within so long [s]",
    ),
]
type Prefer = Annotated[
    str | None,
    Header(max_length=200, description="`wait=S` does what `?wait=S` does (RFC 7240)"),
]
type IdempotencyKey = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=200,
        description="The same key and request give the same job, however often they are sent",
    ),
]


def seconds_to_wait(wait: float | None, prefer: str | None, longest: float) -> float:
    """Return how long to wait [s]: the parameter, else the preference, else not at all."""
    if wait is not None:
        return min(wait, longest)
    found = _PREFERENCE.search(prefer or "")
    return min(float(found[1]), longest) if found else 0.0
