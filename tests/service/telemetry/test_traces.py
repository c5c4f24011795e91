"""A request, the task that a worker runs for it, and its stages are spans of one trace."""

import asyncio
import json
import logging
import subprocess
import sys
import threading
from collections import defaultdict
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import httpx
import pytest
from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest
from opentelemetry.sdk.trace import TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from typer.testing import CliRunner

from service.app import create_app
from service.cli.app import app as commands
from service.jobs.dispatch.spans import run_traced
from service.jobs.event_buffer import NullSink
from service.jobs.json_text import Encoded
from service.jobs.outcome import Returned
from service.jobs.worker.assignment import Assignment
from service.settings import Settings
from service.telemetry import traces
from service.telemetry.ids import with_ids
from service.telemetry.logs import LineFormatter
from tests.profiles import only_campaign
from tests.service.conftest import BLOCK_SCENE, TestClient
from tests.service.servers import ARM, PLAIN, request_of, server, until

TRACE = "0af7651916cd43dd8448eb211c80319c"
PARENT = {"traceparent": f"00-{TRACE}-b7ad6b7169203331-01"}
STAGES = {"load", "goals", "search", "retime", "certify", "samples"}
PLAN = {"group": "arm", "goal": {"type": "configuration", "name": "ready"}}


@pytest.fixture
def exporter():
    kept = InMemorySpanExporter()
    provider = TracerProvider()
    provider.add_span_processor(SimpleSpanProcessor(kept))
    traces.use_tracing(provider)
    yield kept
    traces.stop_tracing()


@pytest.fixture
def traced(exporter, tmp_path):
    settings = Settings(engine="inline", data_dir=tmp_path, query_timeout=300)
    with TestClient(create_app(settings)) as client:
        yield client


def below(spans, parent):
    """The spans whose parent is another one, by name."""
    return {
        span.name: span
        for span in spans
        if span.parent and span.parent.span_id == parent.context.span_id
    }


def test_a_plan_is_one_trace_down_to_its_stages(traced, exporter):
    scene = traced.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]
    exporter.clear()
    body = {**PLAN, "scene": scene, "search": {"allowed_planning_time": 60.0}}
    headers = {**PARENT, "X-Request-ID": "mine"}
    job = traced.post("/v1/plans?wait=60", json=body, headers=headers).json()
    assert job["state"] == "succeeded"
    spans = exporter.get_finished_spans()
    (request,) = [span for span in spans if span.name == "POST /v1/plans"]
    assert {span.context.trace_id for span in spans} == {int(TRACE, 16)}
    task = below(spans, request)["task plan"]
    assert task.attributes["wayproof.job_id"] == job["id"]
    assert task.attributes["wayproof.request_id"] == "mine"
    stages = below(spans, task)
    assert set(stages) >= STAGES
    assert task.start_time <= min(stage.start_time for stage in stages.values())
    assert task.end_time >= max(stage.end_time for stage in stages.values())
    assert all(span.status.is_ok or span.status.is_unset for span in spans)


def test_a_failure_is_noted_where_it_was(traced, exporter):
    scene = traced.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]
    exporter.clear()
    body = {**PLAN, "scene": scene, "start": [0.0] * 6}
    job = traced.post("/v1/plans?wait=60", json=body).json()
    code = job["failure"]["code"]
    failed = [span for span in exporter.get_finished_spans() if not span.status.is_unset]
    assert {span.name for span in failed} == {"task plan", job["failure"]["stage"]}
    assert {span.attributes["wayproof.code"] for span in failed} == {code}


def test_questions_are_traced_and_health_is_not(traced, exporter):
    scene = traced.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]
    exporter.clear()
    traced.get("/healthz")
    traced.get("/metrics")
    assert exporter.get_finished_spans() == ()
    answer = traced.post(
        f"/v1/scenes/{scene}/check", json={"group": "arm", "configurations": [[0] * 6]}
    )
    assert answer.is_success, answer.text
    names = {span.name for span in exporter.get_finished_spans()}
    assert {"POST /v1/scenes/{scene}/check", "task check"} <= names


class Told:
    """A worker that returns at once, and keeps what it was told."""

    async def run(self, run):
        self.run_told = run
        return Returned(Encoded("{}"), None)


def test_the_worker_is_told_the_span_of_its_task(exporter):
    worker = Told()
    run = Assignment("echo", Encoded("{}"), NullSink(), ids={**PARENT, "job_id": "j1"})
    asyncio.run(run_traced(worker, run))
    (span,) = exporter.get_finished_spans()
    told = worker.run_told.ids
    assert told["traceparent"] == f"00-{TRACE}-{span.context.span_id:016x}-01"
    with with_ids(told):
        line = LineFormatter("json").format(logging.makeLogRecord({"msg": "x", "name": "service"}))
    assert json.loads(line)["trace_id"] == TRACE
    assert "traceparent" not in line


def test_nothing_is_imported_without_the_setting():
    code = """
import sys
from service.app import create_app
import service.cli.server, service.jobs.worker.main, service.jobs.dispatch.attempt
create_app()
print([name for name in ("opentelemetry.sdk", "opentelemetry.exporter") if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_server_says_that_the_extra_is_missing(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "opentelemetry.sdk.trace", None)
    monkeypatch.setenv("WAYPROOF_OTLP_ENDPOINT", "http://localhost:4318")
    command = ["serve", "--engine", "inline", "--port", "0", "--data-dir", str(tmp_path)]
    done = CliRunner().invoke(commands, command)
    assert done.exit_code == 1
    (line,) = done.stderr.splitlines()
    assert "extra `telemetry`" in line


@contextmanager
def collector():
    """Where spans go by OTLP over HTTP: yields its URL, and what came."""
    spans = []

    class Receiver(BaseHTTPRequestHandler):
        def do_POST(self):
            sent = self.rfile.read(int(self.headers["Content-Length"]))
            if self.headers.get("Content-Encoding") == "gzip":
                import gzip

                sent = gzip.decompress(sent)
            request = ExportTraceServiceRequest.FromString(sent)
            for resource in request.resource_spans:
                named = {item.key: item.value.string_value for item in resource.resource.attributes}
                for scope in resource.scope_spans:
                    spans.extend((self.path, named["service.name"], span) for span in scope.spans)
            self.send_response(200)
            self.send_header("Content-Type", "application/x-protobuf")
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Receiver) as listening:
        thread = threading.Thread(target=listening.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{listening.server_port}", spans
        finally:
            listening.shutdown()
            thread.join()


@only_campaign("8 s")
def test_a_collector_gets_what_workers_in_processes_do(tmp_path):
    with collector() as (url, spans):
        with server(tmp_path, WAYPROOF_OTLP_ENDPOINT=url) as running:
            scene = running.client.add_scene(ARM)
            body = request_of(scene, seed=4)
            path = f"{running.url}/v1/plans?wait=60"
            plan = httpx.post(path, json=body, headers=PARENT, timeout=120, **PLAIN).json()
            until(lambda: running.client.plan(plan["id"]).finished_at)
        # The server has ended, and sent what it had.
        found = [span for _, _, span in spans if span.trace_id.hex() == TRACE]
        assert {(place, service) for place, service, _ in spans} == {("/v1/traces", "wayproof")}
    children = defaultdict(dict)
    for span in found:
        children[span.parent_span_id.hex()][span.name] = span
    request = children["b7ad6b7169203331"]["POST /v1/plans"]
    task = children[request.span_id.hex()]["task plan"]
    named = {item.key: item.value.string_value for item in task.attributes}
    assert named["wayproof.job_id"] == plan["id"]
    assert set(children[task.span_id.hex()]) >= STAGES
