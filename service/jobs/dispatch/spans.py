"""run_traced(): a run in a worker, with a span of the task and of each of its stages."""

import json
from dataclasses import replace

from service.jobs.json_text import Encoded
from service.jobs.outcome import Outcome, Returned, error_of
from service.jobs.worker.assignment import Assignment, EventSink, Worker
from service.telemetry.traces import TaskSpan, is_tracing, task_span

STAGE = "stage"


async def run_traced(worker: Worker, run: Assignment) -> Outcome:
    """Run a task in a worker to its end; the worker is told the span, if there is one."""
    if not is_tracing():
        return await worker.run(run)
    with task_span(run.task, run.ids) as (span, ids):
        outcome = await worker.run(replace(run, sink=_StageSpans(run.sink, span), ids=ids))
        if not isinstance(outcome, Returned):
            error = error_of(outcome, 1)
            span.fail(error.code, error.detail)
        return outcome


class _StageSpans:
    """Passes events on, and begins a span with each stage."""

    def __init__(self, sink: EventSink, span: TaskSpan) -> None:
        self._sink = sink
        self._span = span

    def put(self, event_type: str, data: Encoded, *, is_update: bool = False) -> None:
        """Take an event."""
        if event_type == STAGE:
            self._span.begin_stage(str(json.loads(data.text).get(STAGE, "")))
        self._sink.put(event_type, data, is_update=is_update)

    async def wait_for_space(self) -> None:
        """Wait while too many events have been taken and not been dealt with."""
        await self._sink.wait_for_space()
