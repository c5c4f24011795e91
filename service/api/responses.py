"""What endpoints declare: problem documents by status, and parameters that many of them share."""

from typing import Annotated, Any

from fastapi import Header, Path, Query

_DESCRIPTIONS = {
    400: "The body or a parameter cannot be read, or the server is not meant by that name",
    403: "A page of another origin asks",
    404: "There is no such resource",
    405: "The resource does not do that",
    408: "The body did not arrive in time",
    409: "Impossible in this scene or state",
    413: "The body is too large",
    415: "The body has a content type that is not read here",
    422: "The request has a fault by itself",
    429: "The queue is full; try again after `Retry-After` seconds",
    499: "The client closed its connection",
    500: "An unexpected fault of the server",
    503: "The server cannot do that now; try again after `Retry-After` seconds",
}


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the declaration of problem documents for these statuses, and for those of them all.

    What takes a body, and so has 413, can also have 408 and 415.
    """
    of_bodies = {408, 415} if 413 in statuses else set[int]()
    schema = {"$ref": "#/components/schemas/Problem"}
    return {
        status: {
            "description": _DESCRIPTIONS[status],
            "content": {"application/problem+json": {"schema": schema}},
        }
        for status in sorted({*statuses, *of_bodies, 400, 403, 500, 503})
    }


type Limit = Annotated[int, Query(ge=1, le=200, description="How many on a page")]
type Cursor = Annotated[
    str | None,
    Query(pattern=r"^[0-9]{1,18}$", description="`next` of the page before; none for the first"),
]
type SceneId = Annotated[str, Path(max_length=128, description="Id of a scene")]
type Revision = Annotated[
    int | None, Query(ge=1, le=2**31 - 1, description="Of the scene; by default the latest")
]
type PlanId = Annotated[str, Path(max_length=128, description="Id of a plan")]
type ExecutionId = Annotated[str, Path(max_length=128, description="Id of an execution")]
type RegionsId = Annotated[str, Path(max_length=128, description="Id of regions")]
type LastEventId = Annotated[
    str | None,
    Header(
        alias="Last-Event-ID",
        max_length=40,
        description="Id of the last event that was seen; those after it are sent",
    ),
]
