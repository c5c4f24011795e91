"""A worker that is a thread answers in time, whatever its task does."""

import asyncio

import pytest

from planning.errors import Canceled
from service.jobs.outcome import Crashed, Raised, Returned, Terminated, TimedOut
from service.jobs.worker.thread_worker import ThreadWorker
from tests.service.jobs.conftest import GUARD
from tests.service.jobs.worker.test_process_worker import Sink, run_of


def test_outcomes():
    async def story():
        worker = ThreadWorker(is_exclusive=True)
        sink = Sink()
        assert isinstance(await worker.run(run_of("echo", sink)), Returned)
        assert [kind for kind, _ in sink.events] == ["stage"]
        assert isinstance(await worker.run(run_of("refuse")), Raised)
        assert await worker.run(run_of("leave")) == Crashed(None, "SystemExit: 3")
        assert await worker.run(run_of("spin", allowed=0.1)) == TimedOut(0.1)
        await worker.close()

    asyncio.run(story())


def test_cancel():
    async def story():
        worker = ThreadWorker(is_exclusive=True)
        sink = Sink()
        running = asyncio.create_task(worker.run(run_of("spin", sink)))
        await sink.seen.wait()
        worker.cancel(GUARD)
        outcome = await running
        assert isinstance(outcome, Terminated)
        assert isinstance(outcome.error, Canceled)

    asyncio.run(story())


@pytest.mark.parametrize("allowed", [None, 0.1])
def test_what_does_not_end_is_given_up_and_its_thread_is_not_used(tmp_path, allowed):
    async def story():
        worker = ThreadWorker(is_exclusive=False)
        sink = Sink()
        file = tmp_path / "end"
        work = run_of("wait_for_file", sink, allowed, file=str(file))
        running = asyncio.create_task(worker.run(work))
        await sink.seen.wait()
        if allowed is None:
            worker.cancel(0.1)
        outcome = await running
        assert outcome == (Terminated() if allowed is None else TimedOut(0.1))
        waiting = asyncio.create_task(worker.ready())
        await asyncio.sleep(0.02)
        assert not waiting.done()
        file.touch()
        await waiting
        assert isinstance(await worker.run(run_of("echo")), Returned)

    asyncio.run(story())


def test_a_task_may_say_by_when_it_has_to_end():
    async def story():
        worker = ThreadWorker(is_exclusive=False)
        late = run_of("reckon", allowed=GUARD, terms=[(0.1, 0.6)])
        assert await worker.run(late) == TimedOut(0.1)
        await worker.ready()

    asyncio.run(story())


def test_exclusive_tasks_take_turns(tmp_path):
    async def story():
        first, second = ThreadWorker(is_exclusive=True), ThreadWorker(is_exclusive=True)
        file = tmp_path / "end"
        sink = Sink()
        long = asyncio.create_task(first.run(run_of("wait_for_file", sink, file=str(file))))
        await sink.seen.wait()
        short = asyncio.create_task(second.run(run_of("echo")))
        await asyncio.sleep(0.05)
        assert not short.done()
        file.touch()
        assert isinstance(await long, Returned)
        assert isinstance(await short, Returned)

    asyncio.run(story())
