"""Connection: HTTP by the standard library, so that what is measured is the service.

A client's library takes 1 to 2 ms of a request and its answer, as much as much of the service.
"""

import http.client
import json
from dataclasses import dataclass
from typing import Any

import httpx


@dataclass(frozen=True)
class Answer:
    """An answer, or why there is none.

    Attributes:
        body: As it came.
        fault: Why it does not count, in a few words; None if it does.
    """

    body: bytes
    fault: str | None

    def json(self) -> Any:
        """Return the body, decoded."""
        return json.loads(self.body)


class Connection:
    """One connection to a server, which is kept."""

    def __init__(self, url: str) -> None:
        """Prepare; the first request opens it.

        Args:
            url: Of the server.
        """
        address = httpx.URL(url)
        self._http = http.client.HTTPConnection(address.host, address.port, timeout=65)

    def post(self, path: str, body: bytes) -> Answer:
        """Return the answer to JSON, whose last byte has come; what is no success is a fault."""
        try:
            self._http.request("POST", path, body, {"Content-Type": "application/json"})
            answer = self._http.getresponse()
            found = answer.read()
        except (OSError, http.client.HTTPException) as fault:
            self._http.close()
            return Answer(b"", type(fault).__name__)
        return Answer(found, None if answer.status < 300 else str(answer.status))

    def close(self) -> None:
        """End it."""
        self._http.close()
