"""A worker that dies is told in the log and counted, also where the job succeeds later."""

import asyncio
import logging

import pytest

from service.jobs.dispatch.calls import Call
from service.jobs.dispatch.crash import Run, note_crash
from service.jobs.dispatch.observer import Observer
from service.jobs.errors import WorkerCrashed
from service.jobs.outcome import Crashed, Lost, MemoryExceeded, Raised, Silent, Terminated, TimedOut
from tests.service.jobs.conftest import GUARD, running, spec

LOGGER = "service.jobs.dispatch.crash"


class Counting(Observer):
    def __init__(self):
        self.crashes = []

    def note_crash(self, queue, reason):
        self.crashes.append((queue, reason))


def told(caplog):
    """What each line about a crash says: task, stage, signal, attempt."""
    fields = ("task", "stage", "signal", "attempt")
    lines = [record for record in caplog.records if record.name == LOGGER]
    assert all(line.levelno == logging.WARNING for line in lines)
    return [tuple(getattr(line, field) for field in fields) for line in lines]


def test_a_crash_whose_second_attempt_succeeds_is_told_and_counted(tmp_path, caplog):
    async def story():
        observer = Counting()
        async with running(tmp_path, observer=observer) as (dispatcher, _):
            marker = {"marker": str(tmp_path / "marker")}
            job = await dispatcher.submit(spec("die_once", payload=marker, max_attempts=2))
            ended = await dispatcher.wait(job.id, GUARD)
            assert (ended.state, ended.attempts) == ("succeeded", 2)
        return observer.crashes

    assert asyncio.run(story()) == [("plan", "exit")]
    assert told(caplog) == [("fake.die_once", "", "exit", 1)]


def test_every_attempt_that_crashes_is_told_with_its_stage(tmp_path, caplog):
    async def story():
        observer = Counting()
        async with running(tmp_path, observer=observer) as (dispatcher, _):
            job = await dispatcher.submit(spec("die_in_stage", max_attempts=2))
            assert (await dispatcher.wait(job.id, GUARD)).state == "failed"
        return observer.crashes

    assert asyncio.run(story()) == [("plan", "SIGSEGV")] * 2
    assert told(caplog) == [("fake.die_in_stage", "search", "SIGSEGV", n) for n in (1, 2)]


def test_calls_that_crash_are_told_as_well(tmp_path, caplog):
    async def story():
        observer = Counting()
        async with running(tmp_path, observer=observer) as (dispatcher, _):
            with pytest.raises(WorkerCrashed):
                await dispatcher.call(Call("fake.segfault", {}, "plan", GUARD, GUARD))
        return observer.crashes

    assert asyncio.run(story()) == [("plan", "SIGSEGV")] * 2
    assert told(caplog) == [("fake.segfault", "", "SIGSEGV", n) for n in (1, 2)]


@pytest.mark.parametrize(
    ("outcome", "reason"),
    [
        (Crashed(-9), "SIGKILL"),
        (Crashed(-250), "signal 250"),
        (Crashed(3, "SystemExit: 3"), "exit"),
        (Crashed(None, "it spoke nonsense"), "exit"),
        (Silent(2.0), "silence"),
        (MemoryExceeded(3, 2), "memory"),
    ],
)
def test_a_reason_is_one_of_few(outcome, reason):
    observer = Counting()
    note_crash(outcome, Run("plan", "fake.echo", 1), observer)
    assert observer.crashes == [("plan", reason)]


@pytest.mark.parametrize(
    "outcome",
    [Terminated(), TimedOut(1.0), Raised(WorkerCrashed("x")), Lost("host", has_begun=True)],
)
def test_what_is_ended_on_request_or_lost_with_its_machine_is_no_crash(outcome, caplog):
    observer = Counting()
    note_crash(outcome, Run("plan", "fake.echo", 1), observer)
    assert (observer.crashes, told(caplog)) == ([], [])
