"""Document: the OpenAPI document, and which schemas requests and answers are made of."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

type Schema = Mapping[str, Any]

_METHODS = ("get", "post", "put", "patch", "delete")


@dataclass(frozen=True)
class Operation:
    """One method of one path.

    Attributes:
        method: In capitals.
        path: With its parameters in braces.
        id: As the document calls it, in camel case.
        summary: One sentence.
        parameters: Of path, query and headers.
        bodies: Schema of the request by media type; empty for none.
        answers: Schema of a success by media type; empty for none.
    """

    method: str
    path: str
    id: str
    summary: str
    parameters: tuple[Schema, ...]
    bodies: Mapping[str, Schema]
    answers: Mapping[str, Schema]


@dataclass(frozen=True)
class Document:
    """What a server can do, and the schemas by name."""

    schemas: Mapping[str, Schema]
    operations: tuple[Operation, ...]
    problems: frozenset[str]

    @classmethod
    def of(cls, file: Path) -> Self:
        """Read a document from a file."""
        document: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        return cls.from_json(document)

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Self:
        """Take a document apart."""
        operations: list[Operation] = []
        problems: set[str] = set()
        for path, methods in document["paths"].items():
            for method, said in methods.items():
                if method in _METHODS:
                    operations.append(_operation(method, path, said))
                    problems.update(_references(_failed(said)))
        return cls(document["components"]["schemas"], tuple(operations), frozenset(problems))

    def requested(self) -> list[str]:
        """Return the names of all schemas that requests are made of, sorted."""
        bodies = [list(operation.bodies.values()) for operation in self.operations]
        return self._reachable(bodies)

    def answered(self) -> list[str]:
        """Return the names of all schemas that answers and problems are made of, sorted."""
        answers: list[Any] = [list(operation.answers.values()) for operation in self.operations]
        return self._reachable([answers, [{"$ref": name} for name in self.problems]])

    def _reachable(self, roots: Any) -> list[str]:
        names: set[str] = set()
        left = list(_references(roots))
        while left:
            name = left.pop()
            if name not in names:
                names.add(name)
                left.extend(_references(self.schemas[name]))
        return sorted(names)


def _operation(method: str, path: str, said: Schema) -> Operation:
    good = [answer for status, answer in said["responses"].items() if status.startswith("2")]
    return Operation(
        method=method.upper(),
        path=path,
        id=said["operationId"],
        summary=_sentence(said),
        parameters=tuple(said.get("parameters", ())),
        bodies=_contents(said.get("requestBody", {})),
        answers=_contents(good[0]),
    )


def _contents(said: Schema) -> dict[str, Schema]:
    return {media: content["schema"] for media, content in said.get("content", {}).items()}


def _failed(said: Schema) -> list[Schema]:
    return [answer for status, answer in said["responses"].items() if status[0] in "45"]


def _sentence(said: Schema) -> str:
    """Return the first paragraph of a description, else the summary, in one line."""
    text = str(said.get("description") or said.get("summary", ""))
    return " ".join(text.split("\n\n", maxsplit=1)[0].split())


def _references(schema: Any) -> Iterator[str]:
    """Yield the names that a schema refers to; examples refer to nothing."""
    if isinstance(schema, Mapping):
        for key, value in schema.items():
            if key == "$ref":
                yield str(value).rsplit("/", 1)[-1]
            elif key not in {"example", "examples", "default", "not"}:
                yield from _references(value)
    elif isinstance(schema, list | tuple):
        for one in schema:
            yield from _references(one)
