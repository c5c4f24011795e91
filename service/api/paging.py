"""Pages of lists: the same parameters for all of them, and opaque cursors."""

import base64
import binascii
import re
from typing import Annotated

from fastapi import Query
from pydantic import AfterValidator

# What a cursor holds: the place in the list after which a page begins.
_HELD = re.compile(rb"after=([0-9]{1,18})")

type Limit = Annotated[int, Query(ge=1, le=200, description="Number of items on a page")]
type OfScene = Annotated[str | None, Query(max_length=128, description="Only those in this scene")]


def cursor_of(sequence: int | None) -> str | None:
    """Return the cursor of the page that begins after the item with this number, if any."""
    if sequence is None:
        return None
    return base64.urlsafe_b64encode(f"after={sequence}".encode()).decode().rstrip("=")


def sequence_of(cursor: str) -> int:
    """Return the number of the item after which a page begins.

    Raises:
        ValueError: It is no cursor; a number is one, as older servers gave it.
    """
    if re.fullmatch(r"[0-9]{1,18}", cursor):
        return int(cursor)
    try:
        held = base64.b64decode(cursor + "=" * (-len(cursor) % 4), b"-_", validate=True)
    except binascii.Error:
        held = b""
    found = _HELD.fullmatch(held)
    if found is None:
        message = "it is not the `next` of a page"
        raise ValueError(message)
    return int(found[1])


def _checked(cursor: str | None) -> str | None:
    if cursor is not None:
        sequence_of(cursor)
    return cursor


type Cursor = Annotated[
    str | None,
    Query(
        pattern=r"^[A-Za-z0-9_-]{1,40}$",
        description="`next` of the page before; none for the first",
    ),
    AfterValidator(_checked),
]


def before(cursor: str | None) -> int | None:
    """Return the number before which a page begins, None for the first page."""
    return None if cursor is None else sequence_of(cursor)
