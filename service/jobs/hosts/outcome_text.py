"""Outcomes as texts: how a host tells the dispatcher how a run ended."""

import json
from collections.abc import Callable, Mapping
from typing import Any

from planning.errors import WayproofError
from service.jobs.json_text import encode
from service.jobs.outcome import (
    Crashed,
    MemoryExceeded,
    Outcome,
    Raised,
    Returned,
    Silent,
    Terminated,
    TimedOut,
    returned,
)
from service.jobs.worker.protocol import dump_error, load_error


def dump_outcome(outcome: Outcome) -> bytes:
    """Return a line that says how a run ended; of a result, a line of its summary and all of it.

    Raises:
        ValueError: It is one that no host can tell.
    """
    rest = ""
    match outcome:
        case Returned(result=result, summary=summary):
            fields: dict[str, Any] = {"end": "returned"}
            # In JSON a line feed stands between tokens only.
            brief = "" if summary is None else summary.text.replace("\n", " ")
            rest = f"{brief}\n{result.text}"
        case Raised(error=error):
            fields = {"end": "raised", "error": dump_error(error)}
        case Crashed(exit_code=exit_code, reason=reason):
            fields = {"end": "crashed", "exit_code": exit_code, "reason": reason}
        case TimedOut(time_limit=limit, error=error, grace=grace):
            fields = {"end": "timed_out", "time_limit": limit, "grace": grace}
            fields["error"] = _dumped(error)
        case Silent(seconds=seconds):
            fields = {"end": "silent", "seconds": seconds}
        case MemoryExceeded(used=used, bound=bound):
            fields = {"end": "memory_exceeded", "used": used, "bound": bound}
        case Terminated(error=error):
            fields = {"end": "terminated", "error": _dumped(error)}
        case _:
            message = f"no host tells of {outcome}"
            raise ValueError(message)
    return f"{encode(fields)}\n{rest}".encode()


def load_outcome(body: bytes) -> Outcome:
    """Return the outcome that a host told.

    Raises:
        ValueError: It is none.
        KeyError: It lacks something.
    """
    first, _, rest = body.decode("utf-8").partition("\n")
    fields = json.loads(first)
    if fields["end"] == "returned":
        brief, _, result = rest.partition("\n")
        return returned(brief, result)
    if fields["end"] == "raised":
        return Raised(load_error(fields["error"]))
    if fields["end"] not in _OTHERS:
        message = f"there is no end {fields['end']!r}"
        raise ValueError(message)
    return _OTHERS[fields["end"]](fields)


def _dumped(error: WayproofError | None) -> str | None:
    return None if error is None else dump_error(error)


def _loaded(text: str | None) -> WayproofError | None:
    return None if text is None else load_error(text)


_OTHERS: Mapping[str, Callable[[dict[str, Any]], Outcome]] = {
    "crashed": lambda fields: Crashed(fields["exit_code"], fields["reason"]),
    "timed_out": lambda fields: TimedOut(
        fields["time_limit"], _loaded(fields["error"]), fields["grace"]
    ),
    "silent": lambda fields: Silent(fields["seconds"]),
    "memory_exceeded": lambda fields: MemoryExceeded(fields["used"], fields["bound"]),
    "terminated": lambda fields: Terminated(_loaded(fields["error"])),
}
