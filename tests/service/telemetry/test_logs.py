"""Every record is one line, has the ids of what it is for, and tells no secret."""

import asyncio
import json
import logging
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.states import JobState
from service.telemetry.ids import bind_ids, bound_ids, with_ids
from service.telemetry.logs import LineFormatter
from service.telemetry.masking import masked
from tests.service.jobs.conftest import GUARD, running, spec

HERE = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
FORMS = ("text", "json")
LINE, OBJECT = (LineFormatter(form) for form in FORMS)


def record(message="it is so", *args, name="service.x", exc_info=None, **more):
    made = logging.LogRecord(name, logging.WARNING, "f.py", 1, message, args, exc_info)
    made.__dict__ |= more
    return made


def fail(message):
    raise ValueError(message)


def fault(message="bad"):
    try:
        fail(message)
    except ValueError:
        return sys.exc_info()


@given(text=st.text(), detail=st.text(), extra=st.text())
def test_whatever_is_said_takes_one_line(text, detail, extra):
    said = record("%s", text, exc_info=fault(detail), extra=extra)
    for line in (LINE.format(said), OBJECT.format(said)):
        assert len(line.splitlines()) == 1
        assert "Traceback (most recent call last)" in line
        assert "\x1b" not in line
    found = json.loads(OBJECT.format(said))
    assert found["event"] == masked(text)
    assert found["exception"].startswith("Traceback")


def test_a_line_says_when_how_bad_where_and_what_it_is_for():
    with with_ids({"request_id": "r1", "job_id": "j1"}):
        found = json.loads(OBJECT.format(record("%d of %s", 3, "them", seconds=1.5)))
        text = LINE.format(record("%d of %s", 3, "them"))
    assert list(found)[:4] == ["time", "level", "logger", "event"]
    assert found["level"] == "warning"
    assert found["logger"] == "service.x"
    assert found["event"] == "3 of them"
    assert (found["request_id"], found["job_id"], found["seconds"]) == ("r1", "j1", 1.5)
    assert "service.x: 3 of them" in text
    assert "request_id=r1  job_id=j1" in text
    assert "request_id" not in OBJECT.format(record())


def test_lines_about_requests_have_their_parts_and_no_query():
    args = ("10.0.0.1:5", "GET", "/v1/plans?key=hidden", "1.1", 200)
    said = record('%s - "%s %s HTTP/%s" %d', *args, name="uvicorn.access")
    found = json.loads(OBJECT.format(said))
    assert found["event"] == "request"
    assert (found["method"], found["path"], found["status"]) == ("GET", "/v1/plans", 200)
    assert "hidden" not in LINE.format(said) + OBJECT.format(said)


@pytest.mark.parametrize(
    "text",
    [
        "postgresql+psycopg://robot:HIDDEN@db.example.org/plans is gone",
        "cannot use postgresql://robot:HID:DEN@[::1]:5432/plans",
        "Authorization: Bearer HIDDEN",
        "{'authorization': 'Basic HIDDEN'}",
        '{"api_key": "HIDDEN"}',
        "WAYPROOF_PASSWORD=HIDDEN",
        "refused: X-API-Key: HIDDEN, and so on",
    ],
)
@pytest.mark.parametrize("form", FORMS)
def test_secrets_are_masked_wherever_they_are(text, form):
    shown = LineFormatter(form).format(record("it failed: %s", text, exc_info=fault(text), x=text))
    for part in ("HIDDEN", "HID:", ":DEN"):
        assert part not in shown
    assert shown.count("***") >= 3


def test_what_is_no_secret_is_told():
    for text in ("http://127.0.0.1:8470/docs", "12:30: a@b.c wrote", "the token ring"):
        assert masked(text) == text


def test_the_first_line_imports_structlog_and_no_start_does():
    code = """
import sys, logging, service.cli.serve, service.cli.server, service.jobs.worker.main
from service.telemetry.logs import LogTerms, configure_logs
configure_logs(LogTerms())
before = "structlog" in sys.modules
logging.getLogger("service").warning("now")
print(before, "structlog" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True"]
    (line,) = done.stderr.splitlines()
    assert json.loads(line)["event"] == "now"


WORKER = """
import asyncio
from service.jobs.event_buffer import NullSink
from service.jobs.json_text import Encoded
from service.jobs.worker.assignment import Assignment
from service.jobs.worker.main import Terms
from service.jobs.worker.process_worker import ProcessWorker
from service.telemetry.logs import LogTerms

async def story():
    terms = Terms(logs=LogTerms("json", "warning"))
    worker = ProcessWorker(["tests.service.jobs.fake_tasks"], terms)
    await worker.open(None)
    await worker.ready()
    for ids in ({"request_id": "r1", "job_id": "j1"}, {"job_id": "j2"}):
        await worker.run(Assignment("fake.blunder", Encoded("{}"), NullSink(), ids=ids))
    await worker.close()

if __name__ == "__main__":
    asyncio.run(story())
"""


def test_lines_of_workers_carry_the_job(tmp_path):
    (tmp_path / "story.py").write_text(WORKER)
    command = [sys.executable, "-W", "ignore", str(tmp_path / "story.py")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=HERE)
    lines = [json.loads(line) for line in done.stderr.splitlines()]
    first, second = lines
    assert (first["request_id"], first["job_id"]) == ("r1", "j1")
    assert second["job_id"] == "j2"
    assert "request_id" not in second
    assert first["exception"].startswith("Traceback")
    assert first["pid"] == second["pid"]


@contextmanager
def lines():
    """The lines that are logged meanwhile, decoded."""
    found = []

    class Lines(logging.Handler):
        def emit(self, record):
            found.append(json.loads(OBJECT.format(record)))

    output = Lines()
    logging.getLogger("service").addHandler(output)
    try:
        yield found
    finally:
        logging.getLogger("service").removeHandler(output)


def test_jobs_are_logged_with_the_request_that_they_were_made_for(tmp_path):
    """Also if they wait until the job of another request has ended."""

    async def submitted(dispatcher, name, task):
        bind_ids({"request_id": name})
        return (await dispatcher.submit(spec(task))).id

    async def story():
        async with running(tmp_path, inline=True) as (dispatcher, _):
            bind_ids({"request_id": "other"})
            names = [f"r{i}" for i in range(4)]
            ids = await asyncio.gather(
                *(asyncio.create_task(submitted(dispatcher, name, "blunder")) for name in names)
            )
            for job in ids:
                assert (await dispatcher.wait(job, GUARD)).state is JobState.FAILED
            return dict(zip(ids, names, strict=True))

    with lines() as logged:
        jobs = asyncio.run(story())
    failed = [line for line in logged if "a task failed" in line["event"]]
    assert {line["job_id"]: line["request_id"] for line in failed} == jobs
    assert bound_ids() == {}
