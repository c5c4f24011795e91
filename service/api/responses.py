"""What endpoints declare and how they answer: problem documents by status, and recorded JSON.

A result goes out as the text that the database has: it is not read here.
"""

from collections.abc import AsyncIterator, Collection, Mapping
from typing import Any

from anyio import to_thread
from fastapi import Response
from fastapi.responses import StreamingResponse

from service.api.models import ResponseModel
from service.jobs.json_steps import STEP, member_of, without_members
from service.jobs.json_text import Encoded

_JSON = "application/json"
# What is declared of an answer that is a page by itself.
HTML_PAGE: dict[str, Any] = {
    "content": {
        "text/html": {"schema": {"type": "string", "description": "A page that needs nothing else"}}
    }
}
_DESCRIPTIONS = {
    400: "The body or a parameter cannot be read, or the server is not meant by that name",
    401: "There is no valid key with the request",
    403: "A page of another origin asks, or the key lacks the scope",
    404: "There is no such resource",
    405: "The resource does not do that",
    408: "The body did not arrive in time",
    409: "Impossible in this scene or state",
    412: "The resource is not what `If-Match` says",
    413: "The body is too large",
    415: "The body has a content type that is not read here",
    422: "The request has a fault by itself",
    429: "The queue is full, or there are too many requests; try again after `Retry-After` seconds",
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


def accepted(
    model: type[ResponseModel], what: str, *refusals: int
) -> dict[int | str, dict[str, Any]]:
    """Return the declaration of what a request for a job is answered with.

    Args:
        model: Of the job.
        what: It is, as words.
        refusals: Statuses of problem documents.
    """
    location = {"description": f"Address of {what}", "schema": {"type": "string"}}
    return {
        200: {"model": model, "description": "Ended within the time that was waited"},
        202: {
            "description": "Accepted; `Location` says where to poll",
            "headers": {"Location": location},
        },
        **problems(*refusals),
    }


async def whole(
    brief: ResponseModel,
    found: Encoded | None,
    told: Response | None = None,
    left_out: Collection[str] = (),
    known: Mapping[str, str] | None = None,
) -> Response:
    """Return the answer of a job in full.

    Args:
        brief: The job without its result.
        found: What the task gave, whose member `result` is the job's.
        told: Status and headers of the answer, if they are not the usual ones.
        left_out: Members of the job's result that the answer does not carry.
        known: Members of `brief` that were written as JSON before.
    """
    text = "" if found is None else found.text
    if len(text) <= STEP:
        result = _result_in(text, left_out)
    else:
        result = await to_thread.run_sync(_result_in, text, left_out)
    known = known or {}
    more = "".join(f',"{name}":{text}' for name, text in known.items())
    head = f'{brief.model_dump_json(exclude=set(known))[:-1]}{more},"result":'.encode()
    result = result or "null"
    status = 200 if told is None else told.status_code or 202
    headers = {} if told is None else dict(told.headers)
    if len(result) <= STEP:
        return Response(head + result.encode() + b"}", status, headers, _JSON)
    headers["content-length"] = str(len(head) + len(result) + 1)
    return StreamingResponse(_in_pieces(head, result), status, headers, _JSON)


def _result_in(text: str, left_out: Collection[str]) -> str | None:
    result = member_of(text, "result")
    if result is None or result == "null" or not left_out:
        return result
    return without_members(result, left_out)


def passed_on(
    found: Encoded, status: int = 200, headers: Mapping[str, str] | None = None
) -> Response:
    """Return an answer that is what a task gave, with headers of its own."""
    told = dict(headers or {})
    if len(found.text) <= STEP:
        return Response(found.text.encode(), status, told, _JSON)
    told["content-length"] = str(len(found.text))
    return StreamingResponse(_in_pieces(b"", found.text, b""), status, told, _JSON)


async def _in_pieces(head: bytes, text: str, tail: bytes = b"}") -> AsyncIterator[bytes]:
    """Yield bytes of which the server sends one before it asks for the next; the text is ASCII."""
    yield head
    for i in range(0, len(text), STEP):
        yield text[i : i + STEP].encode("ascii")
    yield tail
