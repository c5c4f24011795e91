"""Caller: sends calls, and returns what the server answers."""

import threading
from collections.abc import Iterator
from typing import Any, Self

import httpx

from wayproof_client.call import Call
from wayproof_client.connection import (
    ANSWER_TIMEOUT,
    adapter,
    after,
    options,
    request_of,
    retries,
    stream_of,
)
from wayproof_client.errors import checked
from wayproof_client.events import Event, decode_events


class Caller:
    """Speaks to one server. Use it as a context manager, or close it."""

    def __init__(
        self,
        url: str,
        *,
        key: str | None = None,
        timeout: float = ANSWER_TIMEOUT,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        """Speak to a server.

        Args:
            url: Of the server, for example `http://127.0.0.1:8470`.
            key: API key, if the server asks for one.
            timeout: How long an answer may take [s], beside what a request asks to wait.
            transport: What carries the requests, None for the network.
        """
        self._timeout = timeout
        self._http = httpx.Client(**options(url, key, timeout), transport=transport)

    def __enter__(self) -> Self:
        """Begin to use it."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close all connections."""
        self.close()

    @property
    def url(self) -> str:
        """URL of the server."""
        return str(self._http.base_url).rstrip("/")

    def close(self) -> None:
        """Close all connections."""
        self._http.close()

    def ask(self, call: Call, kind: Any) -> Any:
        """Return the answer as a model."""
        return adapter(kind).validate_json(self.send(call).content)

    def ask_nothing(self, call: Call) -> None:
        """Send a call whose answer is empty."""
        self.send(call)

    def ask_text(self, call: Call) -> str:
        """Return the answer as a text."""
        return self.send(call).text

    def ask_bytes(self, call: Call) -> bytes:
        """Return the answer as it came."""
        return self.send(call).content

    def ask_events(self, call: Call, kind: Any) -> Iterator[Any]:
        """Yield events as models, as `ask_raw_events` yields them as they come."""
        for event in self.ask_raw_events(call):
            yield adapter(kind).validate_python(event.document)

    def ask_raw_events(self, call: Call) -> Iterator[Event]:
        """Yield events until the server ends the stream.

        A stream that breaks goes on after the last event that came.

        Raises:
            ApiError: The server refuses.
            httpx.TransportError: The stream broke, and several tries to go on failed.
        """
        last, left = "", retries()
        while True:
            try:
                with self._http.stream(**stream_of(after(call, last))) as answer:
                    if answer.is_error:
                        answer.read()
                    for event in decode_events(checked(answer)):
                        last, left = event.id or last, retries()
                        yield event
            except httpx.TransportError:
                pause = next(left, None)
                if pause is None:
                    raise
                self._pause(pause)
            else:
                return

    def send(self, call: Call) -> httpx.Response:
        """Return the response to a call.

        Raises:
            ApiError: It is a problem.
            NotModified: It says that nothing has changed.
            httpx.TransportError: The server is not reached.
        """
        return checked(self._http.request(**request_of(call, self._timeout)))

    def _pause(self, seconds: float) -> None:
        threading.Event().wait(seconds)
