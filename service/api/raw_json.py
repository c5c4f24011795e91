"""A job with its result, which goes out as the text that the database has: it is not read here."""

from collections.abc import AsyncIterator, Mapping

from anyio import to_thread
from fastapi import Response
from fastapi.responses import StreamingResponse

from service.api.models import ResponseModel
from service.jobs.json_steps import STEP, member_of
from service.jobs.json_text import Encoded

_JSON = "application/json"


async def whole(
    brief: ResponseModel, found: Encoded | None, told: Response | None = None
) -> Response:
    """Return the answer of a job in full.

    Args:
        brief: The job without its result.
        found: What the task gave, whose member `result` is the job's.
        told: Status and headers of the answer, if they are not the usual ones.
    """
    text = "" if found is None else found.text
    if len(text) <= STEP:
        result = member_of(text, "result")
    else:
        result = await to_thread.run_sync(member_of, text, "result")
    head = f'{brief.model_dump_json()[:-1]},"result":'.encode()
    result = result or "null"
    status = 200 if told is None else told.status_code or 202
    headers = {} if told is None else dict(told.headers)
    if len(result) <= STEP:
        return Response(head + result.encode() + b"}", status, headers, _JSON)
    headers["content-length"] = str(len(head) + len(result) + 1)
    return StreamingResponse(_in_pieces(head, result), status, headers, _JSON)


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
