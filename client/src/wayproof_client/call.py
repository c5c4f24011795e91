"""Call: one operation with its arguments, as an HTTP request has it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import quote

from pydantic import BaseModel

_JSON = "application/json"


@dataclass(frozen=True)
class Call:
    """What is asked of a server.

    Attributes:
        method: In capitals.
        path: With parameters in braces.
        inserted: Parameters of the path.
        query: Those that are None are left out.
        headers: Those that are None are left out.
        body: JSON-compatible, with arrays of numpy if need be; a model; or a text as it is.
        media_type: Of a body that is a text.
    """

    method: str
    path: str
    inserted: Mapping[str, str] = field(default_factory=dict[str, str])
    query: Mapping[str, Any] = field(default_factory=dict[str, Any])
    headers: Mapping[str, str | None] = field(default_factory=dict[str, str | None])
    body: Any = None
    media_type: str = _JSON

    def request(self) -> dict[str, Any]:
        """Return the arguments of `httpx.Client.request`.

        Raises:
            ValueError: A number of the body is not finite.
            TypeError: Something of the body is no JSON.
        """
        headers = {name: value for name, value in self.headers.items() if value is not None}
        said: dict[str, Any] = {
            "method": self.method,
            "url": self.url,
            "params": {name: value for name, value in self.query.items() if value is not None},
        }
        if self.body is not None:
            is_text = isinstance(self.body, str | bytes)
            headers["Content-Type"] = self.media_type if is_text else _JSON
            said["content"] = _content(self.body)
        return said | {"headers": headers}

    @property
    def url(self) -> str:
        """Return the path with its parameters in place, quoted."""
        return self.path.format(**{
            name: quote(str(value), safe="") for name, value in self.inserted.items()
        })

    @property
    def waits(self) -> float:
        """Return how long the server may wait before it answers [s]."""
        return float(self.query.get("wait") or 0.0)


def _content(body: Any) -> bytes:
    if isinstance(body, bytes):
        return body
    if isinstance(body, str):
        return body.encode()
    if isinstance(body, BaseModel):
        return body.model_dump_json(exclude_unset=True).encode()
    return json.dumps(body, default=_plain, allow_nan=False).encode()


def _plain(value: Any) -> Any:
    """Return what JSON has for a model, or for an array or a number of numpy."""
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json", exclude_unset=True)
    if hasattr(value, "tolist"):
        return value.tolist()
    message = f"{type(value).__name__} is no JSON"
    raise TypeError(message)
