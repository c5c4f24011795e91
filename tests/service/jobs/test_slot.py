"""A slot outlives whatever its process does, and its process never outlives what it should."""

import asyncio
import os
import signal
import time
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from planning.errors import Canceled, GoalUnreachable
from service.jobs.json_text import Encoded
from service.jobs.outcome import Crashed, Ended, Raised, Returned, TimedOut
from service.jobs.slot import ProcessSlot, Run
from tests.service.jobs.conftest import TASKS


class Sink:
    """Keeps events; `seen` is set by the first."""

    def __init__(self):
        self.events = []
        self.seen = asyncio.Event()

    def put(self, event_type, data: Encoded):
        self.events.append((event_type, data.text))
        self.seen.set()

    async def room(self):
        await asyncio.sleep(0)


@asynccontextmanager
async def open_slot(warm_up=f"{TASKS}:warm"):
    slot = ProcessSlot([TASKS])
    await slot.open(warm_up)
    try:
        async with asyncio.timeout(30):
            await slot.ready()
            yield slot
    finally:
        await slot.close()


def run_of(task, sink=None, allowed=None, **payload):
    return Run(f"{TASKS}:{task}", payload, sink or Sink(), allowed)


def is_alive(pid):
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):  # gone before or while it is read
        return False


async def pid_of(slot):
    outcome = await slot.run(run_of("wait_for_file", file="/"))
    assert isinstance(outcome, Returned)
    return int(outcome.result.text.split(":")[1].strip("}"))


CRASHES = {
    "segfault": Crashed(-signal.SIGSEGV),
    "leave_quietly": Crashed(0),
    "leave": Crashed(70, "SystemExit: 3"),
    "interrupt": Crashed(70, "KeyboardInterrupt: "),
    "exhaust": Crashed(70, "MemoryError"),
    "close_everything": Crashed(-signal.SIGKILL),
    "babble": None,
}


@pytest.mark.parametrize("task", CRASHES)
def test_a_crash_is_told_and_the_next_task_runs(task):
    async def story():
        async with open_slot() as slot:
            outcome = await slot.run(run_of(task))
            assert isinstance(outcome, Crashed)
            assert CRASHES[task] in {None, outcome}
            assert isinstance(await slot.run(run_of("echo")), Returned)

    asyncio.run(story())


def test_what_a_task_raises_keeps_the_process():
    async def story():
        async with open_slot() as slot:
            before = await pid_of(slot)
            outcome = await slot.run(run_of("refuse"))
            assert isinstance(outcome, Raised)
            assert isinstance(outcome.error, GoalUnreachable)
            assert await pid_of(slot) == before

    asyncio.run(story())


def test_a_process_killed_while_idle_is_replaced_at_once():
    async def story():
        async with open_slot() as slot:
            pid = await pid_of(slot)
            os.kill(pid, signal.SIGKILL)
            until = time.monotonic() + 10
            while (now := await _pid_or_crash(slot)) in {pid, None}:
                assert time.monotonic() < until
            assert is_alive(now)

    asyncio.run(story())


async def _pid_or_crash(slot):
    outcome = await slot.run(run_of("wait_for_file", file="/"))
    return int(outcome.result.text[7:-1]) if isinstance(outcome, Returned) else None


@pytest.mark.parametrize(("task", "most"), [("spin", 0.2), ("hang", 1.0)])
def test_cancel_asks_first_and_then_ends(task, most):
    async def story():
        async with open_slot() as slot:
            sink = Sink()
            running = asyncio.create_task(slot.run(run_of(task, sink)))
            await sink.seen.wait()
            began = time.monotonic()
            slot.cancel(0.25)
            slot.cancel(0.25)
            outcome = await running
            assert time.monotonic() - began < most
            assert isinstance(outcome, Ended)
            assert isinstance(outcome.error, Canceled) is (task == "spin")
            assert isinstance(await slot.run(run_of("echo")), Returned)

    asyncio.run(story())


def test_a_cancel_at_any_moment_is_noticed():
    async def story():
        async with open_slot() as slot:
            for steps in range(20):
                running = asyncio.create_task(slot.run(run_of("spin")))
                for _ in range(steps):
                    await asyncio.sleep(0)
                slot.cancel(5.0)
                if steps == 0:  # it had not begun: there was nothing to cancel
                    await asyncio.sleep(0)
                    slot.cancel(5.0)
                assert isinstance(await running, Ended)

    asyncio.run(story())


def test_a_cancel_while_the_process_is_replaced_is_noticed():
    async def story():
        async with open_slot() as slot:
            await slot.run(run_of("segfault"))
            running = asyncio.create_task(slot.run(run_of("hang")))
            await asyncio.sleep(0)
            slot.cancel(30.0)
            async with asyncio.timeout(10):
                assert await running == Ended()

    asyncio.run(story())


def test_a_stale_cancel_ends_nothing():
    async def story():
        async with open_slot() as slot:
            for _ in range(20):
                running = asyncio.create_task(slot.run(run_of("echo")))
                await asyncio.sleep(0.002)
                slot.cancel(5.0)
                await running
                outcome = await slot.run(run_of("wait_for_file", file="/"))
                assert isinstance(outcome, Returned)

    asyncio.run(story())


@pytest.mark.parametrize("task", ["spin", "hang"])
def test_the_deadline_ends_what_does_not_end(task):
    async def story():
        async with open_slot() as slot:
            began = time.monotonic()
            assert await slot.run(run_of(task, allowed=0.2)) == TimedOut(0.2)
            assert 0.2 <= time.monotonic() - began < 1.2
            assert isinstance(await slot.run(run_of("echo", allowed=20.0)), Returned)

    asyncio.run(story())


@pytest.mark.parametrize(
    ("first", "terms", "ended"),
    [
        (30.0, [(0.2, 30.0)], TimedOut(0.2)),
        (0.3, [(30.0, 0.6)], None),
        (30.0, [(0.3, 0.1), (30.0, 0.4)], None),
        (30.0, [(30.0, 0.1), (0.1, 30.0)], TimedOut(0.1)),
    ],
)
def test_a_task_may_say_by_when_it_has_to_end(first, terms, ended):
    async def story():
        async with open_slot() as slot:
            began = time.monotonic()
            outcome = await slot.run(run_of("reckon", allowed=first, terms=terms))
            assert time.monotonic() - began < 3
            assert outcome == ended if ended else isinstance(outcome, Returned)
            assert isinstance(await slot.run(run_of("echo", allowed=20.0)), Returned)

    asyncio.run(story())


def test_large_events_are_cut_and_large_results_are_not():
    async def story():
        async with open_slot() as slot:
            sink = Sink()
            await slot.run(run_of("chatter", sink, count=3, size=200_000))
            assert [text for _, text in sink.events] == ['{"truncated":true,"bytes":200017}'] * 3
            outcome = await slot.run(run_of("vast", count=300_000))
            assert isinstance(outcome, Returned)
            assert len(outcome.result.text) > 2_000_000
            assert outcome.result.text.endswith('"none":null}')

    asyncio.run(story())


def test_a_flood_of_events_arrives_whole_and_in_order():
    async def story():
        async with open_slot() as slot:
            sink = Sink()
            await slot.run(run_of("chatter", sink, count=3000, size=10))
            numbers = [int(text.split(",")[0].split(":")[1]) for _, text in sink.events]
            assert numbers == list(range(3000))

    asyncio.run(story())


def test_closing_ends_the_process_and_giving_up_the_wait_ends_the_task():
    async def story():
        async with open_slot() as slot:
            pid = await pid_of(slot)
            running = asyncio.create_task(slot.run(run_of("hang")))
            await asyncio.sleep(0.05)
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            assert isinstance(await slot.run(run_of("echo")), Returned)
            assert not is_alive(pid)
            last = await pid_of(slot)
        assert not is_alive(last)

    asyncio.run(story())


def test_a_warm_up_that_fails_or_kills_its_process_is_survived(caplog):
    async def story():
        async with open_slot(f"{TASKS}:blunder") as slot:
            assert isinstance(await slot.run(run_of("echo")), Returned)
        slot = ProcessSlot([TASKS])
        await slot.open(f"{TASKS}:segfault")
        await asyncio.sleep(0.4)
        await slot.close()

    asyncio.run(story())
    assert "KeyError" in caplog.text
    assert "died before it was ready" in caplog.text
