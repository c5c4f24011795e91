"""Operations: a method of the client for each, the same ones to call and to await."""

from collections.abc import Iterator
from dataclasses import dataclass

from client.generator.annotations import Annotations, docstring, literal, snake
from client.generator.document import Document, Operation, Schema

_JSON = "application/json"
_EVENTS = "text/event-stream"
_HEAD = '''"""{what}. Made by `python -m client.generator`: never edit it."""

from collections.abc import {imports}
from typing import Literal

from wayproof_client.call import Call
from wayproof_client import models, requests
from wayproof_client.{base_module} import {base}


class {name}({base}):
    """A method for each operation of the document.

    All raise `ApiError` for a problem and `httpx.TransportError` if the server is not reached.
    """
'''
_REQUESTS = Annotations(is_answer=False, prefix="requests.")
_QUERY = Annotations(is_answer=False, prefix="models.")
_ANSWERS = Annotations(is_answer=True, prefix="models.")


@dataclass(frozen=True)
class Flavour:
    """How methods are written: to be called, or to be awaited."""

    what: str
    name: str
    base_module: str
    base: str
    begin: str
    wait: str
    many: str
    imports: str

    def head(self) -> str:
        """Return the beginning of the module."""
        return _HEAD.format(
            what=self.what,
            imports=self.imports,
            base_module=self.base_module,
            base=self.base,
            name=self.name,
        )


SYNC = Flavour(
    "Operations, to be called", "Operations", "caller", "Caller", "def", "", "Iterator", "Iterator"
)
ASYNC = Flavour(
    "Operations, to be awaited",
    "AsyncOperations",
    "async_caller",
    "AsyncCaller",
    "async def",
    "await ",
    "AsyncIterator",
    "AsyncIterator",
)


def operations_text(document: Document, flavour: Flavour) -> str:
    """Return the module of all operations in a flavour."""
    methods = [
        text for operation in document.operations for text in _methods(document, operation, flavour)
    ]
    return "\n\n".join([flavour.head(), *methods]) + "\n"


def _methods(document: Document, operation: Operation, flavour: Flavour) -> Iterator[str]:
    name = snake(operation.id)
    if _EVENTS in operation.answers:
        yield _events(operation, flavour)
        return
    others = [media for media in operation.answers if media != _JSON]
    if _JSON in operation.answers and others:
        yield _one(operation, name, flavour, left_out={"format"})
        yield _one(operation, f"{name}_as", flavour, media=None)
    else:
        yield _one(operation, name, flavour)
    item = _item_of_page(document, operation)
    if item is not None:
        yield _pages(operation, name, item, flavour)


def _one(
    operation: Operation,
    name: str,
    flavour: Flavour,
    *,
    left_out: set[str] | None = None,
    media: str | None = _JSON,
) -> str:
    """Return a method that asks once."""
    kind, verb = _answer(operation, media)
    parameters = [one for one in operation.parameters if one["name"] not in (left_out or set())]
    required = {"format"} if media is None else set[str]()
    call = _call(operation, parameters)
    argument = f", {kind}" if verb == "ask" else ""
    body = f"        return {flavour.wait}self.{verb}({call}{argument})"
    if verb == "ask_nothing":
        body = body.replace("return ", "", 1)
    signature = _signature(operation, parameters, required)
    told = docstring(operation.summary or name, "        ")
    return f"    {flavour.begin} {name}({signature}) -> {kind}:\n{told}\n{body}"


def _answer(operation: Operation, media: str | None) -> tuple[str, str]:
    """Return the annotation of an answer, and which method of the caller asks for it."""
    if not operation.answers:
        return "None", "ask_nothing"
    if media is None:
        return "bytes", "ask_bytes"
    if media in operation.answers:
        return _ANSWERS.of(operation.answers[media]), "ask"
    kind = next(iter(operation.answers))
    return ("str", "ask_text") if _is_text(kind) else ("bytes", "ask_bytes")


def _is_text(media: str) -> bool:
    return media.startswith("text/") or media.endswith("+xml")


def _events(operation: Operation, flavour: Flavour) -> str:
    kind = _ANSWERS.of(operation.answers[_EVENTS])
    signature = _signature(operation, operation.parameters, set())
    call = _call(operation, operation.parameters)
    told = docstring(operation.summary, "        ")
    result = f"{flavour.many}[{kind}]"
    name = snake(operation.id)
    return (
        f"    def {name}({signature}) -> {result}:\n{told}\n"
        f"        return self.ask_events({call}, {kind})"
    )


def _pages(operation: Operation, name: str, item: str, flavour: Flavour) -> str:
    """Return a method that goes through all pages."""
    parameters = [one for one in operation.parameters if one["name"] != "cursor"]
    signature = _signature(operation, parameters, set())
    asked = [one for one in parameters if one["in"] != "path"]
    given = ", ".join([
        *(one["name"] for one in parameters if one["in"] == "path"),
        *(f"{snake(one['name'])}={snake(one['name'])}" for one in asked),
        "cursor=cursor",
    ])
    told = docstring(operation.summary.removesuffix(".") + ": all pages.", "        ")
    every = "all_" + name.removeprefix("list_")
    return (
        f"    {flavour.begin} {every}({signature}) -> {flavour.many}[{item}]:\n{told}\n"
        f"        cursor: str | None = None\n"
        f"        while True:\n"
        f"            page = {flavour.wait}self.{name}({given})\n"
        f"            for item in page.items:\n"
        f"                yield item\n"
        f"            cursor = page.next\n"
        f"            if cursor is None:\n"
        f"                return"
    )


def _item_of_page(document: Document, operation: Operation) -> str | None:
    """Return the annotation of what is on a page, None for an answer that is no page."""
    if all(one["name"] != "cursor" for one in operation.parameters):
        return None
    page: Schema = document.schemas[operation.answers[_JSON]["$ref"].rsplit("/", 1)[-1]]
    return _ANSWERS.of(page["properties"]["items"]["items"])


def _signature(
    operation: Operation, parameters: tuple[Schema, ...] | list[Schema], required: set[str]
) -> str:
    inner = ["self", *(f"{one['name']}: {_of(one)}" for one in _in_path(operation))]
    named: list[str] = []
    if operation.bodies:
        inner.append(f"body: {_body(operation)}")
        if len(operation.bodies) > 1:
            kinds = ", ".join(literal(media) for media in operation.bodies if media != _JSON)
            named.append(f"media_type: Literal[{literal(_JSON)}, {kinds}] = {kinds.split(', ')[0]}")
    for one in parameters:
        if one["in"] == "path":
            continue
        name = snake(one["name"])
        if name in required:
            named.insert(0, f"{name}: {_of(one)}")
        else:
            named.append(f"{name}: {_optional(one)} = None")
    return ", ".join([*inner, "*", *named] if named else inner)


def _in_path(operation: Operation) -> list[Schema]:
    """Return the parameters of the path in the order in which it has them."""
    found = [one for one in operation.parameters if one["in"] == "path"]
    return sorted(found, key=lambda one: operation.path.index(f"{{{one['name']}}}"))


def _of(parameter: Schema) -> str:
    return _QUERY.of(parameter["schema"])


def _optional(parameter: Schema) -> str:
    kind = _of(parameter)
    return kind if kind.endswith("| None") else f"{kind} | None"


def _body(operation: Operation) -> str:
    kind = _REQUESTS.of(operation.bodies[_JSON])
    return f"{kind} | str | bytes" if len(operation.bodies) > 1 else kind


def _call(operation: Operation, parameters: tuple[Schema, ...] | list[Schema]) -> str:
    """Return the expression of a call."""
    parts = [literal(operation.method), literal(operation.path)]
    of = {
        place: ", ".join(
            f"{literal(one['name'])}: {snake(one['name'])}"
            for one in parameters
            if one["in"] == place
        )
        for place in ("path", "query", "header")
    }
    for place, word in (("path", "inserted"), ("query", "query"), ("header", "headers")):
        if of[place]:
            parts.append(f"{word}={{{of[place]}}}")
    if operation.bodies:
        parts.append("body=body")
        if len(operation.bodies) > 1:
            parts.append("media_type=media_type")
    return f"Call({', '.join(parts)})"
