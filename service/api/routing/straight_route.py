"""StraightRoute: the usual request is read at once; whatever else it may be, FastAPI reads it.

FastAPI asks of each request anew what the endpoint's parameters are like, which takes as long as
all that a plan needs until it is with its worker. Here that is asked once. What does not fit in the
plainest way (another content type, escapes in the query, a fault anywhere) is read by FastAPI from
the beginning, and so is refused as it would be anyway.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from inspect import iscoroutinefunction
from typing import Any, get_args, override

from fastapi import Response
from fastapi.dependencies.models import Dependant
from starlette.requests import ClientDisconnect
from starlette.types import Message, Receive, Scope, Send

from planning.errors import UnknownName
from service.api.routing.json_body import RepeatedKey, decode_json
from service.api.routing.strict_route import StrictRequest, StrictRoute, located_in_request

_JSON = b"application/json"
_TRACED = "fastapi.telemetry"


@dataclass(frozen=True)
class _Reader:
    """Reads the parameters of one endpoint from requests in the plainest form.

    Attributes:
        body: Name and field of the body.
        query: Fields of the query by their names in requests.
        headers: Fields of headers by their names in requests.
        defaults: Of both, by the names of parameters.
        request: Name of the parameter that is the request; None without one.
        response: Name of the parameter that has the headers of the answer; None without one.
    """

    body: Any
    query: Mapping[str, Any]
    headers: Mapping[bytes, Any]
    defaults: Mapping[str, Any]
    request: str | None
    response: str | None

    @classmethod
    def of(cls, dependant: Dependant, *, is_embedded: bool) -> "_Reader | None":
        """Return the reader of an endpoint; None of one that needs more than FastAPI's fields.

        Args:
            dependant: What the endpoint takes.
            is_embedded: Whether its body is a member of what is sent.
        """
        plain = [*dependant.query_params, *dependant.header_params]
        more = (dependant.dependencies, dependant.path_params, dependant.cookie_params)
        is_more = any(more) or len(dependant.body_params) != 1 or is_embedded
        if is_more or not all(map(_is_plain, plain)) or not iscoroutinefunction(dependant.call):
            return None
        return cls(
            dependant.body_params[0],
            {field.alias: field for field in dependant.query_params},
            {field.alias.lower().encode(): field for field in dependant.header_params},
            {field.name: None for field in plain},
            dependant.request_param_name,
            dependant.response_param_name,
        )

    def outside_of_body(self, scope: Scope) -> dict[str, Any] | None:
        """Return the parameters of the query and of headers; None if they are not plain."""
        values, found = dict(self.defaults), set[bytes]()
        for name, text in scope["headers"]:
            field = self.headers.get(name)
            if name in found or (name == b"content-type" and text != _JSON):
                return None
            if field is not None or name == b"content-type":
                found.add(name)
            if field is not None and not _take(field, text.decode("latin-1"), values):
                return None
        query: str = scope["query_string"].decode("latin-1")
        is_read = not query or self._read_query(query, values)
        return values if is_read and b"content-type" in found else None

    def _read_query(self, query: str, values: dict[str, Any]) -> bool:
        """Read a query into the parameters; return whether it is plain."""
        found: set[str] = set()
        for part in query.split("&"):
            name, is_pair, text = part.partition("=")
            field = self.query.get(name)
            if not is_pair or field is None or name in found or "%" in text or "+" in text:
                return False
            found.add(name)
            if not _take(field, text, values):
                return False
        return True


class StraightRoute(StrictRoute):
    """A strict route that reads the usual request by itself, if its endpoint makes the answer."""

    @cached_property
    def _reader(self) -> _Reader | None:
        if self.dependant.call is None or not self._answers_itself:
            return None
        return _Reader.of(self.dependant, is_embedded=self._embed_body_fields)

    @property
    def _answers_itself(self) -> bool:
        returned = getattr(self.endpoint, "__annotations__", {}).get("return")
        return returned is Response

    @property
    def reads_at_once(self) -> bool:
        """Whether it reads the usual request by itself."""
        return self._reader is not None

    @override
    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        reader = self._reader
        is_plain = scope["method"] in self.methods and scope.get(_TRACED) is None
        values = None if reader is None or not is_plain else reader.outside_of_body(scope)
        if reader is None or values is None:
            await super().handle(scope, receive, send)
            return
        request = StrictRequest(scope, receive)
        try:
            body = await request.body()
        except ClientDisconnect:
            await super().handle(scope, receive, send)
            return
        if not _take_body(reader.body, body, values):
            await super().handle(scope, _Replayed(body, receive), send)
            return
        if reader.request is not None:
            values[reader.request] = request
        if reader.response is not None:
            values[reader.response] = _unsaid()
        try:
            answer: Response = await self.endpoint(**values)
        except UnknownName as fault:
            raise await located_in_request(fault, request) from fault
        await answer(scope, receive, send)


class _Replayed:
    """A `receive` that gives a body that was read once more."""

    def __init__(self, body: bytes, receive: Receive) -> None:
        self._body: bytes | None = body
        self._receive = receive

    async def __call__(self) -> Message:
        if self._body is None:
            return await self._receive()
        body, self._body = self._body, None
        return {"type": "http.request", "body": body, "more_body": False}


def _is_plain(field: Any) -> bool:
    """Return whether a parameter is one text, or else None."""
    is_many = any(issubclass(kind, Sequence) for kind in _classes(field.field_info.annotation))
    return not is_many and not field.field_info.is_required() and field.get_default() is None


def _classes(annotation: Any) -> list[type[Any]]:
    """Return the classes in a union, but for those of text."""
    parts = get_args(annotation) or (annotation,)
    return [part for part in parts if isinstance(part, type) and not issubclass(part, str)]


def _take(field: Any, content: Any, values: dict[str, Any]) -> bool:
    """Add what a field makes of content to the parameters; return whether it has no fault."""
    values[field.name], faults = field.validate(content, values)
    return not faults


def _take_body(field: Any, body: bytes, values: dict[str, Any]) -> bool:
    """Add a body to the parameters; return whether it has no fault."""
    try:
        document = decode_json(body)
    except (RepeatedKey, ValueError, RecursionError):
        return False
    return _take(field, document, values)


def _unsaid() -> Response:
    """Return an answer of which nothing is said yet, as FastAPI hands it to endpoints."""
    response = Response()
    del response.headers["content-length"]
    response.status_code = None  # pyright: ignore[reportAttributeAccessIssue]
    return response
