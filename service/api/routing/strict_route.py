"""StrictRoute: bodies of the right kind, and no key twice; known parameters of the query only."""

from collections.abc import Callable, Coroutine
from email.message import Message
from functools import cache, cached_property, lru_cache
from typing import Any, override

from fastapi import Request, Response
from fastapi.routing import APIRoute
from pydantic import TypeAdapter
from starlette.exceptions import HTTPException
from starlette.routing import Match
from starlette.types import Scope

from planning.errors import UnknownName
from service.api.names import located
from service.api.params import declared_query, located_in_query, require_known_query
from service.api.routing.json_body import RepeatedKey, decode_json
from service.errors import Refusal, RequestInvalid, UnreadableBody, UnsupportedMediaType, status_of


class CarriedRefusal(HTTPException):
    """A refusal as the one kind of exception that FastAPI lets through while it reads a body."""

    def __init__(self, refusal: Refusal) -> None:
        super().__init__(status_of(refusal), refusal.detail)
        self.refusal = refusal


class StrictRequest(Request):
    """A request whose JSON is what it looks like."""

    @override
    async def json(self) -> Any:
        """Return the body.

        Raises:
            CarriedRefusal: It is not JSON, or has a key twice.
        """
        try:
            return decode_json(await self.body())
        except RepeatedKey as repeated:
            fault = repeated.fault
            shown = {"path": f"body.{fault.path}", "pointer": fault.pointer}
            shown |= {"message": fault.message, "type": fault.type}
            detail = f"body.{fault.path}: {fault.message}"
            raise CarriedRefusal(RequestInvalid(detail, {"faults": [shown]})) from repeated
        except (ValueError, RecursionError) as fault:
            reason = str(fault)[:200] or type(fault).__name__
            position = getattr(fault, "pos", getattr(fault, "start", None))
            evidence = {"position": position, "reason": reason}
            refusal = UnreadableBody(f"the body is not JSON: {reason}", evidence)
            raise CarriedRefusal(refusal) from fault


class StrictRoute(APIRoute):
    """A route that reads JSON, and refuses any other content type (415) and unknown parameters."""

    @cached_property
    def _stem(self) -> str:
        """What all paths begin with that this route takes."""
        return self.path_format.partition("{")[0]

    @override
    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Return whether it takes a request: most do not, which is said without a look further."""
        if not (scope.get("root_path") or scope["path"].startswith(self._stem)):
            return Match.NONE, {}
        return super().matches(scope)

    @override
    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return what FastAPI makes of the endpoint, behind a look at the headers."""
        handler = super().get_route_handler()
        takes_json, known = self.body_field is not None, declared_query(self.dependant)

        async def strict(request: Request) -> Response:
            if takes_json and _has_body(request):
                require_json(request.headers.get("content-type"))
            strict_request = StrictRequest(request.scope, request.receive)
            try:
                require_known_query(request, known)
                return await handler(strict_request)
            except UnknownName as fault:
                raise await located_in_request(fault, strict_request) from fault

        return strict


async def located_in_request(fault: UnknownName, request: StrictRequest) -> UnknownName:
    """Return an error that says where in the request the name stands, if it stands there."""
    if "errors" in fault.evidence:
        return fault
    if not _has_body(request):
        return located_in_query(fault, request)
    try:
        document = decode_json(await request.body())
        steps = tuple[str | int, ...]()
        if "operation" in fault.evidence:  # of those of an edit
            steps = ("operations", fault.evidence["operation"])
            document = document["operations"][fault.evidence["operation"]]
    except (RepeatedKey, ValueError, LookupError):
        return fault
    return located(fault, document, steps)


def require_json(content_type: str | None) -> None:
    """Go on only if a body is JSON by what its sender says.

    Raises:
        UnsupportedMediaType: It is said to be something else, or nothing is said.
    """
    kind = kind_of(content_type)
    if kind != "application/json" and not kind.endswith("+json"):
        known = ["application/json"]
        detail = f"bodies are read as {known[0]}, not {kind or 'without a content type'}"
        raise UnsupportedMediaType(detail, {"got": kind, "known": known})


@lru_cache(64)
def kind_of(content_type: str | None) -> str:
    """Return the media type in a `Content-Type`, "" where there is none."""
    if content_type is None:
        return ""
    message = Message()
    message["content-type"] = content_type
    return message.get_content_type()


def body_schema(request: Request) -> dict[str, Any] | None:
    """Return the JSON schema of the body that the endpoint of a request wants."""
    route = request.scope.get("route")
    if not isinstance(route, APIRoute) or route.body_field is None:
        return None
    return _schema_of(route.body_field.field_info.annotation)


@cache
def _schema_of(kind: Any) -> dict[str, Any]:
    return TypeAdapter(kind).json_schema()


def _has_body(request: Request) -> bool:
    length = request.headers.get("content-length", "0")
    return length != "0" or "transfer-encoding" in request.headers
