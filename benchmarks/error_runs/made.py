"""Made: a failure that was made to happen, with what led to it and how to show it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

type Place = tuple[float, float, float]


@dataclass(frozen=True)
class Page:
    """A page to take a picture of.

    Attributes:
        html: Its text.
        camera: Where the camera is, and what it looks at, p_WC and p_WT [m]; None for as it is.
    """

    html: str
    camera: tuple[Place, Place] | None = None


@dataclass(frozen=True)
class Made:
    """A failure that was made to happen.

    Attributes:
        code: Of the failure.
        call: Method and path of the request.
        body: Of the request, if it is JSON; None for none.
        answer: The problem document, or the failure of a job or of an answer.
        page: Makes what a picture is taken of; None where nothing is to be seen.
        headers: Of the request, where they matter.
    """

    code: str
    call: str
    body: Mapping[str, Any] | None
    answer: Mapping[str, Any]
    page: Callable[[], Page] | None = None
    headers: Mapping[str, str] = field(default_factory=dict[str, str])

    def __post_init__(self) -> None:
        """Refuse what ended otherwise.

        Raises:
            RuntimeError: The answer has another code.
        """
        if self.answer.get("code") != self.code:
            message = f"{self.code}: the request ended with {self.answer}"
            raise RuntimeError(message)

    @property
    def example(self) -> dict[str, Any]:
        """What the guide shows: the request and its answer, without the seconds that it took."""
        answer = {name: part for name, part in self.answer.items() if name != "timings"}
        request: dict[str, Any] = {"headers": dict(self.headers)} if self.headers else {}
        if self.body is not None:
            request["body"] = dict(self.body)
        return {"call": self.call, **request, "answer": answer}


@dataclass(frozen=True)
class Printed:
    """A failure that a command told.

    Attributes:
        code: Of the failure.
        command: As it is typed.
        text: What it printed.
    """

    code: str
    command: str
    text: str

    @property
    def example(self) -> dict[str, Any]:
        """What the guide shows."""
        return {"command": self.command, "printed": self.text.strip()}
