"""Logs of the server and its workers: one line for each record, tracebacks included.

Modules log by the standard library, as uvicorn and asyncio do; structlog makes a line of each. It
takes a tenth of a second to import, so the first line imports it and not the start.
"""

import json
import logging
import sys
from collections.abc import MutableMapping
from dataclasses import dataclass
from typing import Any, Literal, TextIO, override

from service.telemetry.ids import TRACE, bound_ids
from service.telemetry.masking import masked

type LogFormat = Literal["text", "json"]
type LogLevel = Literal["debug", "info", "warning", "error"]
type _Event = MutableMapping[str, Any]

# What is ours, or says what was asked of us; libraries are heard from warnings on.
_OURS = ("service", "planning", "uvicorn")
_ACCESS, AUDIT = "uvicorn.access", "wayproof.audit"
_ACCESS_FIELDS = ("client", "method", "path", "http", "status")
# Not of interest: uvicorn's text in colours, and asyncio's name of the task.
_DROPPED = ("color_message", "positional_args")
# Controls of a terminal, among them line feeds, are no business of who is logged.
_CONTROLS = {
    **{code: f"\\x{code:02x}" for code in (*range(0x20), *range(0x7F, 0xA0))},
    0x0A: "\\n",
    0x0D: "\\r",
    0x09: "\\t",
    0x2028: "\\u2028",
    0x2029: "\\u2029",
}


@dataclass(frozen=True)
class LogTerms:
    """How a process logs.

    Attributes:
        format: Of a line.
        level: Of what is ours: what is less is left out.
    """

    format: LogFormat = "json"
    level: LogLevel = "warning"


def usual_format() -> LogFormat:
    """Return `text` for people at a terminal, `json` for what collects logs."""
    return "text" if sys.stderr.isatty() else "json"


def configure_logs(terms: LogTerms) -> None:
    """Have every record of this process go to its standard error, as one line."""
    output = _StandardError()
    output.setFormatter(LineFormatter(terms.format))
    root, level = logging.getLogger(), getattr(logging, terms.level.upper())
    root.handlers[:] = [output]
    root.setLevel(max(level, logging.WARNING))
    for name in _OURS:
        logging.getLogger(name).setLevel(level)
    logging.getLogger(AUDIT).setLevel(logging.INFO)  # whatever else is left out
    logging.captureWarnings(capture=True)


class LineFormatter(logging.Formatter):
    """Makes one line of a record, by structlog; it is imported with the first one."""

    def __init__(self, form: LogFormat) -> None:
        """Make lines of a form."""
        super().__init__()
        self._form: LogFormat = form
        self._inner: logging.Formatter | None = None

    @override
    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        if self._inner is None:
            self._inner = _structured(self._form)
        return masked(self._inner.format(record))


class _StandardError(logging.StreamHandler[TextIO]):
    """Writes to what is the standard error by then."""

    def __init__(self) -> None:
        super().__init__(sys.stderr)

    @override
    def emit(self, record: logging.LogRecord) -> None:
        self.stream = sys.stderr
        super().emit(record)


def _structured(form: LogFormat) -> logging.Formatter:
    """Return structlog's formatter for records of the standard library."""
    import structlog  # noqa: PLC0415  (see above)

    as_they_come: list[Any] = [
        structlog.stdlib.add_log_level,
        structlog.stdlib.ExtraAdder(),
        structlog.processors.TimeStamper(fmt="iso", utc=True, key="time"),
        _add_origin,
        _name_access,
        structlog.processors.StackInfoRenderer(),
        # Without the values of local variables, among which there may be secrets.
        structlog.processors.format_exc_info,
    ]
    render: Any = structlog.processors.JSONRenderer() if form == "json" else _as_text
    return structlog.stdlib.ProcessorFormatter(
        foreign_pre_chain=as_they_come,
        processors=[structlog.stdlib.ProcessorFormatter.remove_processors_meta, _in_order, render],
        pass_foreign_args=True,
    )


def _add_origin(_: Any, __: str, event: _Event) -> _Event:
    """Say which process it is, which part of it, and what it is done for."""
    record: logging.LogRecord = event["_record"]
    ids = dict(bound_ids())
    if TRACE in ids:  # version, trace, span and flags
        ids["trace_id"] = ids.pop(TRACE).split("-")[1]
    return {**event, "logger": record.name, "pid": record.process, **ids}


def _name_access(_: Any, __: str, event: _Event) -> _Event:
    """Name the parts of a line about a request; its query stays out of it. So with the audit."""
    args = event.get("positional_args")
    if event["logger"] == _ACCESS and isinstance(args, tuple) and len(args) == len(_ACCESS_FIELDS):
        found = dict(zip(_ACCESS_FIELDS, args, strict=True))
        found["path"] = str(found["path"]).partition("?")[0]
        del found["http"]
        event = {**event, "event": "request", **found}
    elif event["logger"] == AUDIT and str(event["event"]).startswith("{"):
        event = {**event, "event": "audit", **json.loads(event["event"])}
    return event


def _in_order(_: Any, __: str, event: _Event) -> _Event:
    """Put first what every line has."""
    first = ("time", "level", "logger", "event")
    rest = {name: item for name, item in event.items() if name not in {*first, *_DROPPED}}
    return {**{name: event[name] for name in first}, **rest}


def _as_text(_: Any, __: str, event: _Event) -> str:
    """Return an event as a line for people."""
    time, level, logger, what = (event.pop(name) for name in ("time", "level", "logger", "event"))
    fields = "".join(f"  {name}={item}" for name, item in event.items())
    return f"{time} {level:<8} {logger}: {what}{fields}".translate(_CONTROLS)
