"""A worker outlives whatever its process does, and its process never outlives what it should.

This holds wherever it runs: on this machine, or on another one of which the dispatcher gets bytes.
"""

import asyncio
import json
import os
import signal
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from planning.errors import Canceled, GoalUnreachable
from service.jobs.json_text import Encoded, encode
from service.jobs.outcome import Crashed, MemoryExceeded, Raised, Returned, Terminated, TimedOut
from service.jobs.worker import process_worker
from service.jobs.worker.assignment import Assignment
from service.jobs.worker.main import Terms
from service.jobs.worker.process import WorkerProcess
from service.jobs.worker.process_worker import ProcessWorker
from tests.service.jobs.conftest import GUARD, TASKS, WARM_UP
from tests.service.jobs.remote.machines import KINDS, workers


class Sink:
    """Keeps events; `seen` is set by the first."""

    def __init__(self):
        self.events = []
        self.seen = asyncio.Event()

    def put(self, event_type, data: Encoded, *, is_update=False):
        self.events.append((event_type, data.text))
        self.seen.set()

    async def wait_for_space(self):
        await asyncio.sleep(0)


@pytest.fixture(params=KINDS)
def kind(request):
    """Where the worker is."""
    return request.param


@pytest.fixture
def open_slot(kind):
    """A context with a worker that is ready."""

    @asynccontextmanager
    async def opened(warm_up=WARM_UP, terms=None):
        (worker,) = workers(kind, [TASKS], [terms or Terms()])
        await worker.open(warm_up)
        try:
            async with asyncio.timeout(GUARD):
                await worker.ready()
                yield worker
        finally:
            await worker.close()

    return opened


def run_of(task, sink=None, allowed=None, **payload):
    return Assignment(f"fake.{task}", Encoded(encode(payload)), sink or Sink(), allowed)


def is_alive(pid):
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):  # gone before or while it is read
        return False


async def pid_of(worker):
    outcome = await worker.run(run_of("wait_for_file", file="/"))
    assert isinstance(outcome, Returned)
    return int(outcome.result.text.split(":")[1].strip("}"))


def test_a_worker_looks_for_garbage_and_not_among_what_was_imported(open_slot):
    async def story():
        async with open_slot() as worker:
            outcome = await worker.run(run_of("garbage"))
            assert isinstance(outcome, Returned)
            told = json.loads(outcome.result.text)
            assert told["looks"]
            assert told["spared"]
            # Python itself begins with some twenty looks; to import these few modules takes sixty.
            assert told["has_looked"] < 50

    asyncio.run(story())


CRASHES = {
    "segfault": Crashed(-signal.SIGSEGV),
    "leave_quietly": Crashed(0),
    "leave": Crashed(70, "SystemExit: 3"),
    "interrupt": Crashed(70, "KeyboardInterrupt: "),
    "exhaust": Crashed(70, "MemoryError"),
    "close_everything": Crashed(-signal.SIGKILL),
}


@pytest.mark.parametrize("task", CRASHES)
def test_a_crash_is_told_and_the_next_task_runs(open_slot, task):
    async def story():
        async with open_slot() as worker:
            outcome = await worker.run(run_of(task))
            assert outcome == CRASHES[task]
            assert isinstance(await worker.run(run_of("echo")), Returned)

    asyncio.run(story())


def test_a_process_that_speaks_nonsense_has_crashed_and_the_next_task_runs(open_slot):
    async def story():
        async with open_slot() as worker:
            assert isinstance(await worker.run(run_of("babble")), Crashed)
            assert isinstance(await worker.run(run_of("echo")), Returned)

    asyncio.run(story())


def test_what_a_task_raises_keeps_the_process(open_slot):
    async def story():
        async with open_slot() as worker:
            before = await pid_of(worker)
            outcome = await worker.run(run_of("refuse"))
            assert isinstance(outcome, Raised)
            assert isinstance(outcome.error, GoalUnreachable)
            assert await pid_of(worker) == before

    asyncio.run(story())


def test_a_process_killed_while_idle_is_replaced_at_once(open_slot):
    async def story():
        async with open_slot() as worker:
            pid = await pid_of(worker)
            os.kill(pid, signal.SIGKILL)
            while (now := await _pid_or_crash(worker)) in {pid, None}:
                pass
            assert is_alive(now)

    asyncio.run(story())


async def _pid_or_crash(worker):
    outcome = await worker.run(run_of("wait_for_file", file="/"))
    return int(outcome.result.text[7:-1]) if isinstance(outcome, Returned) else None


@pytest.mark.parametrize(
    ("task", "grace", "is_kept"), [("spin", GUARD, True), ("hang", 0.1, False)]
)
def test_cancel_asks_first_and_then_ends(open_slot, task, grace, is_kept):
    async def story():
        async with open_slot() as worker:
            pid = await pid_of(worker)
            sink = Sink()
            running = asyncio.create_task(worker.run(run_of(task, sink)))
            await sink.seen.wait()
            worker.cancel(grace)
            worker.cancel(grace)
            outcome = await running
            assert isinstance(outcome, Terminated)
            assert isinstance(outcome.error, Canceled) is is_kept
            assert (await pid_of(worker) == pid) is is_kept

    asyncio.run(story())


def test_a_cancel_at_any_moment_is_noticed(open_slot):
    async def story():
        async with open_slot() as worker:
            for steps in range(20):
                running = asyncio.create_task(worker.run(run_of("spin")))
                for _ in range(steps):
                    await asyncio.sleep(0)
                worker.cancel(5.0)
                if steps == 0:  # it had not begun: there was nothing to cancel
                    await asyncio.sleep(0)
                    worker.cancel(5.0)
                assert isinstance(await running, Terminated)

    asyncio.run(story())


def test_a_cancel_while_the_process_is_replaced_is_noticed(open_slot, tmp_path):
    async def story():
        async with open_slot() as worker:
            await worker.run(run_of("segfault"))
            running = asyncio.create_task(worker.run(run_of("touch", file=str(tmp_path / "ran"))))
            await asyncio.sleep(0)
            worker.cancel(GUARD)
            assert await running == Terminated()
            assert not (tmp_path / "ran").exists()

    asyncio.run(story())


def test_a_stale_cancel_ends_nothing(open_slot):
    async def story():
        async with open_slot() as worker:
            for _ in range(20):
                running = asyncio.create_task(worker.run(run_of("echo")))
                await asyncio.sleep(0.002)
                worker.cancel(5.0)
                await running
                outcome = await worker.run(run_of("wait_for_file", file="/"))
                assert isinstance(outcome, Returned)

    asyncio.run(story())


@pytest.mark.parametrize("task", ["spin", "hang"])
def test_the_deadline_ends_what_does_not_end(open_slot, task):
    async def story():
        async with open_slot() as worker:
            began = asyncio.get_running_loop().time()
            assert await worker.run(run_of(task, allowed=0.2)) == TimedOut(0.2)
            assert asyncio.get_running_loop().time() - began >= 0.2
            assert isinstance(await worker.run(run_of("echo", allowed=GUARD)), Returned)

    asyncio.run(story())


@pytest.mark.parametrize(
    ("terms", "allowed"), [([(0.2, GUARD)], 0.2), ([(GUARD, 0.0), (0.1, GUARD)], 0.1)]
)
def test_a_task_may_say_by_when_it_has_to_end(open_slot, terms, allowed):
    async def story():
        async with open_slot() as worker:
            late = run_of("reckon", allowed=GUARD, terms=terms)
            assert await worker.run(late) == TimedOut(allowed)
            assert isinstance(await worker.run(run_of("echo", allowed=GUARD)), Returned)

    asyncio.run(story())


def test_large_events_are_cut_and_large_results_are_not(open_slot):
    async def story():
        async with open_slot() as worker:
            sink = Sink()
            await worker.run(run_of("chatter", sink, count=3, size=200_000))
            assert [text for _, text in sink.events] == ['{"truncated":true,"bytes":200017}'] * 3
            whole = Sink()
            await worker.run(run_of("chatter", whole, count=3, size=200_000, whole=True))
            assert [len(text) for _, text in whole.events] == [200_017] * 3
            outcome = await worker.run(run_of("vast", count=300_000))
            assert isinstance(outcome, Returned)
            assert len(outcome.result.text) > 2_000_000
            assert outcome.result.text.endswith('"none":null}')

    asyncio.run(story())


def test_a_flood_of_events_arrives_whole_and_in_order(open_slot):
    async def story():
        async with open_slot() as worker:
            sink = Sink()
            await worker.run(run_of("chatter", sink, count=3000, size=10))
            numbers = [int(text.split(",")[0].split(":")[1]) for _, text in sink.events]
            assert numbers == list(range(3000))

    asyncio.run(story())


def test_closing_ends_the_process_and_giving_up_the_wait_ends_the_task(open_slot):
    async def story():
        async with open_slot() as worker:
            pid = await pid_of(worker)
            sink = Sink()
            running = asyncio.create_task(worker.run(run_of("hang", sink)))
            await sink.seen.wait()
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            assert isinstance(await worker.run(run_of("echo")), Returned)
            assert not is_alive(pid)
            last = await pid_of(worker)
        assert not is_alive(last)

    asyncio.run(story())


def test_a_warm_up_that_fails_is_told_and_runs_go_on(open_slot):
    async def story():
        async with open_slot("fake.blunder") as worker:
            assert isinstance(await worker.run(run_of("echo")), Returned)
            assert "KeyError" in worker.fault

    asyncio.run(story())


def test_a_warm_up_that_kills_its_process_is_survived(kind):
    async def story():
        (worker,) = workers(kind, [TASKS], [Terms()])
        assert worker.fault == ("no process" if kind == "local" else "no machine") + " is there"
        await worker.open("fake.segfault")
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(worker.ready(), 1.0)
        assert worker.fault is not None
        await worker.close()

    asyncio.run(story())


def test_a_process_that_hangs_before_it_is_ready_is_replaced(monkeypatch):
    start, asked = WorkerProcess.start, []

    async def hanging_once(context, folder, warm_up, terms):
        asked.append(warm_up)
        return await start(context, folder, warm_up if len(asked) == 1 else None, terms)

    async def story():
        worker = ProcessWorker([TASKS])
        await worker.open("fake.hang")
        try:
            async with asyncio.timeout(GUARD):
                await worker.ready()
            assert isinstance(await worker.run(run_of("echo")), Returned)
        finally:
            await worker.close()

    monkeypatch.setattr(WorkerProcess, "start", hanging_once)
    monkeypatch.setattr(process_worker, "LONGEST_START", 2.0)
    asyncio.run(story())
    assert len(asked) >= 2


BOUND = 300 * 2**20


@pytest.mark.parametrize("chunk", [2**22, 10 * BOUND])
def test_what_takes_too_much_memory_is_ended_and_says_so(open_slot, chunk):
    """Bit by bit, which the server sees, or at once, which the kernel refuses."""

    async def story():
        async with open_slot(terms=Terms(memory=BOUND)) as worker:
            outcome = await worker.run(run_of("grow", chunk=chunk))
            assert isinstance(outcome, MemoryExceeded)
            assert outcome.bound == BOUND
            assert (outcome.used > BOUND) is (chunk < BOUND)
            assert isinstance(await worker.run(run_of("echo")), Returned)

    asyncio.run(story())


def test_a_worker_that_keeps_much_is_replaced_before_the_next_task(open_slot):
    async def story():
        async with open_slot(terms=Terms(memory=BOUND)) as worker:
            pid, generation = await pid_of(worker), worker.generation
            assert await pid_of(worker) == pid
            assert isinstance(await worker.run(run_of("keep", count=BOUND * 3 // 4)), Returned)
            assert await pid_of(worker) != pid
            assert worker.generation == generation + 1
            assert worker.fault is None

    asyncio.run(story())


def test_a_task_that_exceeds_its_memory_may_come_to_rest_first(open_slot, tmp_path):
    async def story():
        terms = Terms(memory=BOUND, memory_grace=GUARD)
        async with open_slot(terms=terms) as worker:
            rest = tmp_path / "rest"
            outcome = await worker.run(run_of("grow", chunk=2**22, most=BOUND, rest=str(rest)))
            assert isinstance(outcome, MemoryExceeded)
            assert rest.exists()

    asyncio.run(story())


def test_a_worker_lets_others_go_before(open_slot):
    async def story():
        async with open_slot(terms=Terms(niceness=7)) as worker:
            outcome = await worker.run(run_of("niceness"))
            assert json.loads(outcome.result.text) == {"niceness": os.nice(0) + 7}

    asyncio.run(story())
