"""Exception handlers: every error that leaves the service is a problem document."""

import errno
import logging
import math
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from sqlalchemy.exc import SQLAlchemyError
from starlette.exceptions import HTTPException
from starlette.routing import Match

from planning.errors import WayproofError
from planning.world.documents.document_faults import Fault, faults_of, value_fault
from service.api.middleware.request_id import HEADER, request_id
from service.api.middleware.response_headers import guard_headers
from service.api.routing.strict_route import CarriedRefusal, body_schema
from service.errors import DiskFull, Refusal, RequestInvalid, UnreadableBody, problem_of
from service.errors import status_of as status_of_error
from service.jobs.errors import RETRY_AFTER, DatabaseUnavailable
from service.jobs.store.sql.database import is_of_database

MEDIA_TYPE = "application/problem+json"
_MAX_FAULTS = 20
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
CODES = {
    400: "unreadable_body",
    404: "not_found",
    405: "method_not_allowed",
    413: "body_too_large",
    415: "unsupported_media_type",
}
_METHODS = ("DELETE", "GET", "PATCH", "POST", "PUT")
_log = logging.getLogger(__name__)


class ProblemResponse(JSONResponse):
    """A problem document."""

    media_type = MEDIA_TYPE


def install(app: FastAPI) -> None:
    """Make every error of `app` a problem document."""
    app.add_exception_handler(WayproofError, _on_error)
    app.add_exception_handler(RequestValidationError, _on_validation_error)
    app.add_exception_handler(HTTPException, _on_http_error)
    app.add_exception_handler(SQLAlchemyError, _on_database)
    app.add_exception_handler(OSError, _on_disk)
    app.add_exception_handler(Exception, _on_surprise)


def finite(content: Any) -> Any:
    """Return JSON content with null for every number that JSON cannot hold."""
    match content:
        case float() if not math.isfinite(content):
            return None
        case str() | bytes():
            return content
        case Mapping():
            return {str(key): finite(item) for key, item in content.items()}
        case Sequence():
            return [finite(item) for item in content]
        case _:
            return content


def respond(error: WayproofError) -> ProblemResponse:
    """Return the answer to a request that ended with one of our errors."""
    status = status_of_error(error)
    content = problem_of(error.code, status, error.detail, finite(error.evidence))
    headers: dict[str, str] = {}
    if status in {429, 503}:
        headers["Retry-After"] = str(math.ceil(error.evidence.get("retry_after", 1)))
    if status in {408, 413}:  # the rest of the body is not waited for
        headers["Connection"] = "close"
    return ProblemResponse(content, status, headers)


def refusal_of(
    faults: Sequence[Mapping[str, Any]], body: Any = None, schema: Mapping[str, Any] | None = None
) -> Refusal:
    """Return our error for pydantic's or FastAPI's list of faults.

    Args:
        faults: Whose locations begin with `body`, `query`, `path` or `header`.
        body: As it was decoded.
        schema: JSON schema of what the body should be.
    """
    first = faults[0]
    if first["type"] == "json_invalid":
        reason = first.get("ctx", {}).get("error", "not JSON")
        evidence = {"position": first["loc"][-1], "reason": reason}
        return UnreadableBody(f"the body is not JSON: {reason}", evidence)
    told = _told(faults, body, schema)
    shown = [_shown(fault) for fault in told[:_MAX_FAULTS]]
    more = f" (and {len(told) - 1} more faults)" if len(told) > 1 else ""
    detail = f"{shown[0]['path'] or 'body'}: {shown[0]['message']}{more}"
    return RequestInvalid(detail, {"faults": shown})


def _told(
    faults: Sequence[Mapping[str, Any]], body: Any, schema: Mapping[str, Any] | None
) -> list[Fault]:
    """Return faults with their place in the request; those of the body by what it is meant as."""
    of_body = [fault for fault in faults if fault["loc"][:1] == ("body",)]
    others = [fault for fault in faults if fault["loc"][:1] != ("body",)]
    whole = {"$defs": (schema or {}).get("$defs", {}), "properties": {"body": schema or {}}}
    around = {} if body is None else {"body": body}
    return [
        *faults_of(of_body, around, whole),
        *(value_fault(tuple(fault["loc"]), fault) for fault in others),
    ]


def _shown(fault: Fault) -> dict[str, Any]:
    """Return what helps of a fault; the input is left out, it may be huge."""
    place = fault.steps[0] if fault.steps else "body"
    pointer = fault.pointer.removeprefix("/body") if place == "body" else ""
    shown = {"path": fault.path, "pointer": pointer, "message": fault.message, "type": fault.type}
    parameter = {} if place == "body" else {"parameter": str(fault.steps[1])}
    return {**shown, **parameter, "nearest": list(fault.nearest)}


def _on_error(_: Request, error: Exception) -> ProblemResponse:
    assert isinstance(error, WayproofError)  # noqa: S101  (Starlette dispatches by class)
    return respond(error)


def _on_validation_error(request: Request, error: Exception) -> ProblemResponse:
    assert isinstance(error, RequestValidationError)  # noqa: S101
    return respond(refusal_of(error.errors(), error.body, body_schema(request)))


def _on_http_error(request: Request, error: Exception) -> ProblemResponse:
    assert isinstance(error, HTTPException)  # noqa: S101
    if isinstance(error, CarriedRefusal):
        return respond(error.refusal)
    code = CODES.get(error.status_code, "http_error")
    detail = str(error.detail)
    if error.status_code in {404, 405}:
        detail = (
            f"{HTTPStatus(error.status_code).phrase}: {request.method} {request.url.path[:200]}"
        )
    content = problem_of(code, error.status_code, detail, {})
    headers = {"Allow": _allowed(request)} if error.status_code == 405 else error.headers
    return ProblemResponse(content, error.status_code, headers)


def _allowed(request: Request) -> str:
    """Return the methods that a path has (RFC 9110, 15.5.6); Starlette names one route's."""
    return ", ".join(method for method in _METHODS if _is_routed(request, method))


def _is_routed(request: Request, method: str) -> bool:
    scope = {**request.scope, "method": method}
    return any(route.matches(scope)[0] is Match.FULL for route in request.app.routes)


def _on_database(request: Request, error: Exception) -> ProblemResponse:
    if not is_of_database(error):
        return _on_surprise(request, error)
    reason = str(getattr(error, "orig", None) or error)[:200]
    _log.error("the database does not do what is asked: %s", reason)
    message = f"the database is full, locked or away: {reason}"
    return respond(DatabaseUnavailable(message, {"reason": reason, "retry_after": RETRY_AFTER}))


def _on_disk(request: Request, error: Exception) -> ProblemResponse:
    if not (isinstance(error, OSError) and error.errno in _NO_ROOM):
        return _on_surprise(request, error)
    reason = error.strerror or type(error).__name__
    _log.error("the data folder takes nothing more: %s", reason)
    message = f"the data folder takes nothing more: {reason}"
    return respond(DiskFull(message, {"reason": reason, "retry_after": RETRY_AFTER}))


def _on_surprise(_: Request, error: Exception) -> ProblemResponse:
    _log.error("unexpected error", exc_info=error)
    kind = type(error).__name__
    content = problem_of("internal_error", 500, f"an unexpected {kind}; see the server's log", {})
    answer = ProblemResponse(content, 500, {HEADER: request_id()})
    guard_headers(answer.headers)  # Starlette handles these outside of all middleware
    return answer
