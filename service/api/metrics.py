"""Metrics of one app for Prometheus: requests, jobs, stages, queues, workers, failures."""

import time
from collections.abc import Mapping
from typing import Any, Literal, override

from fastapi.routing import APIRoute
from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client import disable_created_metrics as leave_out_creation_times
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_0_0_4
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.jobs.dispatch.observer import Observer
from service.jobs.dispatch.scheduling.scheduler import QueueLoad
from service.jobs.job import JobSummary

MEDIA_TYPE = CONTENT_TYPE_PLAIN_0_0_4
_REQUESTS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 60.0)
_STAGES = (0.001, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)

leave_out_creation_times()


class Metrics(Observer):
    """What one app counts; nothing is shared with another one in the same process."""

    def __init__(self) -> None:
        """Begin to count."""
        every = self._registry = CollectorRegistry()
        self._requests = Histogram(
            "wayproof_http_request_duration_seconds",
            "Seconds from a request to the beginning of its answer.",
            ("method", "route", "status"),
            registry=every,
            buckets=_REQUESTS,
        )
        self._stages = Histogram(
            "wayproof_stage_seconds",
            "Seconds of a stage of a job that ended here.",
            ("queue", "stage"),
            registry=every,
            buckets=_STAGES,
        )
        self._failures = Counter(
            "wayproof_job_failures", "Jobs that ended here without a result.", ("queue", "code"),
            registry=every,
        )  # fmt: skip
        self._crashes = Counter(
            "wayproof_worker_crashes",
            "Runs whose worker died, by signal, `exit`, `silence` or `memory`; a second run may "
            "have succeeded.",
            ("queue", "reason"),
            registry=every,
        )
        self._leads = Gauge(
            "wayproof_is_leader", "1 if this server runs the jobs of its database, else 0.",
            registry=every,
        )  # fmt: skip
        self._jobs = Gauge("wayproof_jobs", "Jobs.", ("queue", "state"), registry=every)
        self._lengths = Gauge(
            "wayproof_queue_length", "Jobs and questions that wait.", ("queue",), registry=every
        )
        self._workers = Gauge(
            "wayproof_workers_ready", "Workers that may run what waits in a queue, busy or not.",
            ("queue",), registry=every,
        )  # fmt: skip
        self._busy = Gauge(
            "wayproof_workers_busy", "Workers that run something of a queue.", ("queue",),
            registry=every,
        )  # fmt: skip
        self._waits = Histogram(
            "wayproof_queue_wait_seconds",
            "Seconds that a job or a question waited for a worker.",
            ("queue",),
            registry=every,
            buckets=_STAGES,
        )
        self._worlds = Counter(
            "wayproof_world_cache",
            "Jobs and questions about a scene, by whether their worker had it loaded (hit) or not.",
            ("queue", "outcome"),
            registry=every,
        )

    def note_request(self, scope: Scope, status: int, seconds: float) -> None:
        """Count a request that is answered."""
        route = scope.get("route")
        method, path = "any", "none"
        if isinstance(route, APIRoute) and scope["method"] in route.methods:
            method, path = scope["method"], route.path_format
        self._requests.labels(method, path, str(status)).observe(seconds)

    @override
    def note_assignment(self, queue: str, waited: float, *, was_warm: bool | None) -> None:
        """Count what has waited, and whether its scene is loaded where it runs."""
        self._waits.labels(queue).observe(waited)
        if was_warm is not None:
            self._worlds.labels(queue, "hit" if was_warm else "miss").inc()

    @override
    def note_crash(self, queue: str, reason: str) -> None:
        """Count a worker that died under a run."""
        self._crashes.labels(queue, reason).inc()

    @override
    def note_end(self, job: JobSummary) -> None:
        """Count a job that has ended."""
        if job.failure is not None:
            self._failures.labels(job.queue, str(job.failure.get("code"))).inc()
        end: Any = job.failure or job.result
        timings = end.get("timings") if isinstance(end, Mapping) else None
        for stage, seconds in (timings or {}).items():
            if isinstance(seconds, int | float):
                self._stages.labels(job.queue, stage).observe(seconds)

    def note_role(self, role: Literal["leader", "follower"]) -> None:
        """Note what this server is among those of its database."""
        self._leads.set(role == "leader")

    def exposition(
        self, counts: Mapping[str, Mapping[str, int]], loads: Mapping[str, QueueLoad]
    ) -> str:
        """Return everything as text.

        Args:
            counts: Jobs by state, then by queue.
            loads: What waits and what works, by queue.
        """
        for state, by_queue in counts.items():
            for queue, number in by_queue.items():
                self._jobs.labels(queue, state).set(number)
        for queue, load in loads.items():
            self._lengths.labels(queue).set(load.num_waiting)
            self._workers.labels(queue).set(load.num_ready)
            self._busy.labels(queue).set(load.num_running)
        return generate_latest(self._registry).decode()


class MeasureRequests:
    """Middleware that times requests up to the beginning of the answer, however long it streams."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        """Stand around `app`."""
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        begun, is_answered = time.perf_counter(), False

        async def send_timed(message: Message) -> None:
            nonlocal is_answered
            if message["type"] != "http.response.start":
                await send(message)
                return
            is_answered, seconds = True, time.perf_counter() - begun
            await send(message)
            self._metrics.note_request(scope, message["status"], seconds)

        try:
            await self._app(scope, receive, send_timed)
        except Exception:
            if not is_answered:  # what handles unexpected errors stands around all middleware
                self._metrics.note_request(scope, 500, time.perf_counter() - begun)
            raise
