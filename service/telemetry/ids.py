"""Ids of what is being done: a line of the log carries those that are bound where it comes from.

They travel with a task to its worker. Light: workers import it before anything else.
"""

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from types import MappingProxyType

REQUEST, JOB = "request_id", "job_id"
# Names a trace and a span in it (W3C Trace Context).
TRACE = "traceparent"
_bound: ContextVar[Mapping[str, str]] = ContextVar("ids", default=MappingProxyType({}))


def bound_ids() -> Mapping[str, str]:
    """Return the ids that are bound in this context, by name."""
    return _bound.get()


def bind_ids(ids: Mapping[str, str]) -> None:
    """Have this context, and those that are copied from it later, carry these ids and no others."""
    _bound.set(dict(ids))


@contextmanager
def with_ids(ids: Mapping[str, str]) -> Generator[None]:
    """Carry these ids and no others meanwhile."""
    token = _bound.set(dict(ids))
    try:
        yield
    finally:
        _bound.reset(token)
