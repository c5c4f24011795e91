"""Traces for OpenTelemetry, where the operator wants them; the SDK is not imported otherwise.

A worker may be killed at any moment, and need not reach a collector: so the server, which hears of
every stage as it begins, makes the spans of what its workers do.
"""

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import Any

from service.telemetry.ids import TRACE

_SCOPE = "wayproof"
# Asked every few seconds by what watches a server.
_NOT_TRACED = ("/healthz", "/readyz", "/metrics")
# A server that ends waits no longer for a collector [s].
_PATIENCE = 5
_providers: list[Any] = []


class TracingUnavailable(Exception):
    """What makes traces is not installed."""


def start_tracing(endpoint: str, version: str) -> None:
    """Send spans of this process to a collector (OTLP over HTTP).

    Args:
        endpoint: Its URL, such as `http://localhost:4318`.
        version: Of the server.

    Raises:
        TracingUnavailable: The extra `telemetry` is not installed.
    """
    try:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import (  # noqa: PLC0415
            OTLPSpanExporter,
        )
        from opentelemetry.sdk.resources import Resource  # noqa: PLC0415
        from opentelemetry.sdk.trace import TracerProvider  # noqa: PLC0415
        from opentelemetry.sdk.trace.export import BatchSpanProcessor  # noqa: PLC0415
    except ImportError as fault:
        message = f"traces need the extra `telemetry` (pip install 'wayproof[telemetry]'): {fault}"
        raise TracingUnavailable(message) from fault
    provider = TracerProvider(
        resource=Resource.create({"service.name": "wayproof", "service.version": version}),
        shutdown_on_exit=False,
    )
    exporter = OTLPSpanExporter(endpoint=f"{endpoint.rstrip('/')}/v1/traces", timeout=_PATIENCE)
    provider.add_span_processor(BatchSpanProcessor(exporter))
    use_tracing(provider)


def use_tracing(provider: Any) -> None:
    """Have spans made by a provider."""
    _providers[:] = [provider]


def stop_tracing() -> None:
    """Send what there is, and make no more spans."""
    while _providers:
        _providers.pop().shutdown()


def is_tracing() -> bool:
    """Return whether spans are made."""
    return bool(_providers)


def request_telemetry() -> Any:
    """Return what FastAPI is to make of requests, as its `TelemetryConfig`.

    A span of each, in the trace that it names; nothing where no spans are made, whatever the
    environment says.
    """
    nothing = {"metrics": False, "logs": False, "operation_spans": False, "auto_configure": False}
    if not _providers:
        return {"tracing": False, **nothing}
    return {"tracer_provider": _providers[-1], "exclude": _is_excluded, **nothing}


def _is_excluded(scope: Mapping[str, Any]) -> bool:
    return scope.get("path") in _NOT_TRACED


def trace_ids() -> dict[str, str]:
    """Return what names the present span to others (W3C Trace Context); empty without one."""
    if not _providers:
        return {}
    from opentelemetry.trace.propagation.tracecontext import (  # noqa: PLC0415
        TraceContextTextMapPropagator,
    )

    carrier: dict[str, str] = {}
    TraceContextTextMapPropagator().inject(carrier)
    return {TRACE: carrier[TRACE]} if TRACE in carrier else {}


class TaskSpan:
    """The span of a task in a worker, and one below it for each of its stages."""

    def __init__(self, span: Any, tracer: Any, context: Any) -> None:
        """Begin with no stage; `task_span` makes it."""
        self._span = span
        self._tracer = tracer
        self._context = context
        self._stage: Any = None

    def begin_stage(self, name: str) -> None:
        """End the stage before, and begin one."""
        self._end_stage()
        self._stage = self._tracer.start_span(name, context=self._context)

    def fail(self, code: str, detail: str) -> None:
        """Note that the task, and the stage that it was in, failed."""
        from opentelemetry.trace import Status, StatusCode  # noqa: PLC0415

        for span in (self._span, self._stage):
            if span is not None:
                span.set_attribute("wayproof.code", code)
                span.set_status(Status(StatusCode.ERROR, detail))

    def end(self) -> None:
        """End the task and its stage."""
        self._end_stage()
        self._span.end()

    def _end_stage(self) -> None:
        if self._stage is not None:
            self._stage.end()
            self._stage = None


@contextmanager
def task_span(task: str, ids: Mapping[str, str]) -> Generator[tuple[TaskSpan, Mapping[str, str]]]:
    """Make a span of a task that runs meanwhile.

    Args:
        task: Its name.
        ids: Of what it is run for; the span that they name is the parent.

    Yields:
        The span, and the ids with its own.
    """
    from opentelemetry import trace  # noqa: PLC0415
    from opentelemetry.trace.propagation.tracecontext import (  # noqa: PLC0415
        TraceContextTextMapPropagator,
    )

    propagator = TraceContextTextMapPropagator()
    tracer = _providers[-1].get_tracer(_SCOPE)
    attributes = {f"wayproof.{name}": text for name, text in ids.items() if name != TRACE}
    parent = propagator.extract(dict(ids))
    span = tracer.start_span(f"task {task}", context=parent, attributes=attributes)
    context = trace.set_span_in_context(span, parent)
    carrier: dict[str, str] = {}
    propagator.inject(carrier, context)
    made = TaskSpan(span, tracer, context)
    try:
        yield made, {**ids, TRACE: carrier[TRACE]}
    except BaseException as fault:
        made.fail(type(fault).__name__, "the worker failed, or nothing waits for it any more")
        raise
    finally:
        made.end()
