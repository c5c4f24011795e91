"""Call: one request of the corpus, and how it names what earlier answers made."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class From:
    """A part of an earlier answer.

    Attributes:
        name: Of the call that it was the answer to.
        pointer: Keys and indices down to the part, separated by slashes.
    """

    name: str
    pointer: str = "/id"

    def found(self, answers: Mapping[str, Any]) -> Any:
        """Return the part."""
        part = answers[self.name]
        for step in self.pointer.split("/")[1:]:
            part = part[int(step) if isinstance(part, list) else step]
        return part


@dataclass(frozen=True)
class Call:
    """A request; `{name}` in its path is the id in the answer to an earlier one.

    Attributes:
        name: Unique, a Python identifier.
        method: Of HTTP.
        path: With its query.
        body: JSON that may hold `From`s, or bytes as they are; None for none.
        headers: Beyond those that a body brings.
        until: Asked again until a member of the answer has a value; the last answer counts.
        is_moving: Whether what is asked about goes on meanwhile: state and stage are not compared.
    """

    name: str
    method: str
    path: str
    body: Any = None
    headers: dict[str, str] = field(default_factory=dict)
    until: tuple[str, str] | None = None
    is_moving: bool = False


def filled(part: Any, answers: Mapping[str, Any]) -> Any:
    """Return a body with what earlier answers say in the place of each `From`."""
    if isinstance(part, From):
        return part.found(answers)
    if isinstance(part, dict):
        return {key: filled(inner, answers) for key, inner in part.items()}
    return [filled(inner, answers) for inner in part] if isinstance(part, list) else part


def get(name: str, path: str, **rest: Any) -> Call:
    """Return a call that reads."""
    return Call(name, "GET", path, **rest)


def post(name: str, path: str, body: Any = None, **rest: Any) -> Call:
    """Return a call that asks for something."""
    return Call(name, "POST", path, body, **rest)
