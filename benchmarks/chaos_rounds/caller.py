"""Caller: asks a server that may be gone, full or locked until it has answered."""

import json
import re
import time
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Protocol

import httpx

from benchmarks.chaos_rounds.journal import Event, Journal
from benchmarks.serving.server import pause

# A client that is patient: the longest fault, and the start after it [s].
PATIENCE = 240.0
_ANSWER_WITHIN = 90.0
_GAUGES = re.compile(r"wayproof_(jobs|queue_length|workers_ready|workers_busy|is_leader)\b[{ ]")
# Too much is asked, or the server cannot do it now.
_AGAIN = frozenset({429, 503})


class Address(Protocol):
    """Where the server is now."""

    @property
    def url(self) -> str:
        """Changes when it is started again; empty while there is none."""
        ...

    @property
    def starts(self) -> int:
        """How often one came to listen."""
        ...


class GaveUp(Exception):
    """There is no answer that makes sense; it is in the journal."""


class Caller:
    """One client's connections; used by one thread.

    Attributes:
        address: Of the server.
    """

    def __init__(self, address: Address, journal: Journal) -> None:
        """Ask the server at `address`."""
        self.address = address
        self._journal = journal
        self._http = httpx.Client(timeout=_ANSWER_WITHIN, trust_env=False)

    def close(self) -> None:
        """Close all connections."""
        self._http.close()

    def get(self, path: str) -> Any:
        """Return the JSON of a resource."""
        return self.ask("GET", path).json()

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        *,
        key: str | None = None,
        accepted: frozenset[int] = frozenset(),
    ) -> httpx.Response:
        """Ask again and again until there is an answer that is no "not now".

        Args:
            method: Of HTTP.
            path: Of the resource.
            body: As JSON, if any.
            key: By which the server knows that it is asked again.
            accepted: Refusals that make sense; any other is a violation.

        Raises:
            GaveUp: There was none in time.
        """
        headers = {} if key is None else {"Idempotency-Key": key}
        until = time.monotonic() + PATIENCE
        last = ""
        while time.monotonic() < until:
            try:
                answer = self._send(method, path, body, headers)
            except httpx.ReadTimeout:
                self._journal.blame("no answer", path, f"{method} within {_ANSWER_WITHIN:g} s")
                continue
            except httpx.TransportError as fault:
                last = f"{type(fault).__name__}: {fault}"
                self._journal.count("no connection")
                pause(0.1)
                continue
            last = name_of(answer)
            self._journal.count(last)
            if answer.is_success or answer.status_code in accepted:
                return answer
            if answer.status_code not in _AGAIN:
                what = f"{method}: {last}: {answer.text[:500]}"
                self._journal.blame("unexpected answer", path, what)
                if answer.status_code < 500:
                    raise GaveUp(path)
            pause(0.3)
        self._journal.blame("no answer", path, f"{method} within {PATIENCE:g} s; last: {last}")
        raise GaveUp(path)

    def gauges(self) -> str:
        """Return what the server says of its queues and workers, for people."""
        try:
            lines = self._send("GET", "/metrics", None, {}).text.splitlines()
        except httpx.TransportError as fault:
            return f"no metrics: {fault}"
        return " ".join(line.removeprefix("wayproof_") for line in lines if _GAUGES.match(line))

    def follow(self, path: str, after: int) -> Iterator[Event]:
        """Yield events with numbers above `after`, until the stream or the server ends."""
        headers = {"Last-Event-ID": str(after)}
        try:
            with self._http.stream("GET", self.address.url + path, headers=headers) as stream:
                if stream.is_success:
                    yield from events_in(stream.iter_lines())
        except httpx.TransportError:
            self._journal.count("no connection")

    def _send(
        self, method: str, path: str, body: Any, headers: Mapping[str, str]
    ) -> httpx.Response:
        url = self.address.url
        if not url:
            message = "the server is down"
            raise httpx.ConnectError(message)
        return self._http.request(method, url + path, json=body, headers=headers)


def events_in(lines: Iterable[str]) -> Iterator[Event]:
    """Yield the events of a stream of server-sent events (WHATWG HTML, 9.2)."""
    fields: dict[str, str] = {}
    for line in lines:
        if line:
            name, _, value = line.partition(": ")
            fields[name] = value
        else:
            if "data" in fields and "id" in fields:
                data = json.loads(fields["data"])
                yield Event(int(fields["id"]), fields.get("event", "message"), data)
            fields = {}


def name_of(answer: httpx.Response) -> str:
    """Return the status of an answer, and the code of a refusal."""
    if answer.is_success:
        return str(answer.status_code)
    try:
        return f"{answer.status_code} {answer.json()['code']}"
    except (ValueError, KeyError):
        return str(answer.status_code)
