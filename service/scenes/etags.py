"""Entity tags of scenes (RFC 9110): one for each revision, whose document never changes."""

from typing import Annotated, Any

from fastapi import Header

from service.errors import RevisionMismatch
from service.scenes.store.records import SceneRecord

_MAX_LENGTH = 2000

type IfMatch = Annotated[
    str | None,
    Header(
        alias="If-Match",
        max_length=_MAX_LENGTH,
        description="`ETag` of the revision that is meant, or several, or `*`; if the scene is at "
        "another one by now, nothing is done (412)",
    ),
]
type IfNoneMatch = Annotated[
    str | None,
    Header(
        alias="If-None-Match",
        max_length=_MAX_LENGTH,
        description="`ETag` of a revision that is known already: it is not sent again (304)",
    ),
]

ETAG_HEADER: dict[str, Any] = {
    "ETag": {"description": "Tag of the revision, for `If-Match`", "schema": {"type": "string"}}
}


def etag_of(record: SceneRecord) -> str:
    """Return the strong entity tag of a revision."""
    return f'"{record.id}.{record.revision}.{record.digest[:16]}"'


def check_match(record: SceneRecord, if_match: str | None) -> SceneRecord:
    """Return the latest revision of a scene if it is one that the header names.

    Raises:
        RevisionMismatch: It is another one.
    """
    etag = etag_of(record)
    if if_match is not None and not {"*", etag} & _tags(if_match):
        message = (
            f"scene {record.id} is at revision {record.revision}, which If-Match does not name"
        )
        raise RevisionMismatch(
            message, {"revision": record.revision, "etag": etag, "asked": if_match}
        )
    return record


def is_known(record: SceneRecord, if_none_match: str | None) -> bool:
    """Return whether the header names a revision, whose robots are where it has them.

    Weak tags will do. Of a revision whose robots have moved since, the `positions` that a client
    knows may be old.
    """
    if record.moved:
        return False
    tags = set() if if_none_match is None else _tags(if_none_match)
    return bool({"*", etag_of(record)} & {tag.removeprefix("W/") for tag in tags})


def _tags(header: str) -> set[str]:
    return {tag.strip() for tag in header.split(",")}
