"""Writes happen in order, each once, and whose fault it is comes out with whom it concerns."""

import asyncio
import threading
from contextlib import asynccontextmanager, contextmanager, nullcontext
from functools import partial

import pytest
from sqlalchemy.exc import OperationalError

from service.jobs.errors import DatabaseUnavailable
from service.jobs.store import group_commit as module
from service.jobs.store.group_commit import GroupCommit
from tests.service.jobs.test_stopping import eventually


class Store:
    """Counts transactions; the first ones may fail."""

    def __init__(self, num_faults=0):
        self.durable = []
        self.num_faults = num_faults
        self.num_full = 0
        self.has_begun = threading.Event()
        self.gate = threading.Event()
        self.gate.set()

    def keeping_connection(self):
        return nullcontext()

    @contextmanager
    def transaction(self, *, is_durable):
        self.has_begun.set()
        self.gate.wait(60)
        if self.num_faults > 0:
            self.num_faults -= 1
            raise OperationalError("BEGIN", {}, Exception("database is locked"))
        yield
        self.durable.append(is_durable)

    def flush(self):
        if self.num_full > 0:
            self.num_full -= 1
            raise OSError
        self.durable.append("flush")


@asynccontextmanager
async def writing(store, **options):
    made = GroupCommit(store, **options)
    try:
        yield made
    finally:
        await made.close()


def test_what_waits_goes_together_and_in_order():
    async def story():
        store = Store()
        async with writing(store) as writer:
            store.gate.clear()
            written = []
            first = asyncio.create_task(
                writer.execute(partial(written.append, 0), is_durable=False)
            )
            await asyncio.to_thread(store.has_begun.wait, 60)
            rest = [
                writer.execute(partial(written.append, i), is_durable=i == 7) for i in range(1, 20)
            ]
            tasks = [asyncio.create_task(work) for work in rest]
            await asyncio.sleep(0)
            store.gate.set()
            await asyncio.gather(first, *tasks)
            assert written == list(range(20))
            assert store.durable == [False, True]

    asyncio.run(story())


def test_a_fault_is_told_to_whom_it_concerns():
    async def story():
        store = Store()
        async with writing(store) as writer:
            store.gate.clear()
            works = [partial(int, "1"), partial(int, "x"), partial(int, "3")]
            tasks = [asyncio.create_task(writer.execute(work)) for work in works]
            await asyncio.sleep(0)
            store.gate.set()
            told = await asyncio.gather(*tasks, return_exceptions=True)
            assert told[0] == 1
            assert isinstance(told[1], ValueError)
            assert told[2] == 3

    asyncio.run(story())


@pytest.mark.parametrize(("num_faults", "is_done"), [(3, True), (6, False)])
def test_a_busy_database_is_asked_again(num_faults, is_done):
    async def story():
        async with writing(Store(num_faults), pauses=(0.001,) * 4) as writer:
            if is_done:
                assert await writer.execute(partial(int, "1")) == 1
            else:
                with pytest.raises(OperationalError):
                    await writer.execute(partial(int, "1"))
            assert await writer.execute(partial(int, "2")) == 2

    asyncio.run(story())


def test_what_was_refused_for_being_late_is_never_written():
    async def story():
        store = Store()
        written = []
        async with writing(store) as writer:
            store.gate.clear()
            first = asyncio.create_task(writer.execute(partial(written.append, 0)))
            await asyncio.to_thread(store.has_begun.wait, 60)
            kept = asyncio.create_task(writer.execute(partial(written.append, 1)))
            with pytest.raises(DatabaseUnavailable) as refusal:
                await writer.execute(partial(written.append, 2), within=0.01)
            store.gate.set()
            await asyncio.gather(first, kept)
            await writer.execute(partial(written.append, 3), within=60)
        assert written == [0, 1, 3]
        assert refusal.value.evidence["retry_after"] > 0

    asyncio.run(story())


class SlowToCommit(Store):
    """Commits when told to."""

    def __init__(self):
        super().__init__()
        self.may_commit = threading.Event()
        self.commits = threading.Event()

    @contextmanager
    def transaction(self, *, is_durable):
        yield
        self.commits.set()
        self.may_commit.wait(60)


def test_what_is_being_committed_is_not_refused():
    async def story():
        store = SlowToCommit()
        async with writing(store) as writer:
            done = asyncio.create_task(writer.execute(partial(int, "1"), within=0.05))
            await asyncio.to_thread(store.commits.wait, 60)
            try:
                await asyncio.wait({done}, timeout=0.2)
                assert not done.done()
            finally:
                store.may_commit.set()
            assert await done == 1

    asyncio.run(story())


def test_what_is_refused_leaves_the_others_of_its_transaction():
    """It is withdrawn while the transaction that it is in has begun, and waits."""

    async def story():
        store = Store()
        written, begun, gate = [], threading.Event(), threading.Event()

        def slow():
            begun.set()
            gate.wait(60)
            written.append("slow")

        async with writing(store) as writer:
            store.gate.clear()
            first = asyncio.create_task(writer.execute(partial(written.append, "first")))
            await asyncio.to_thread(store.has_begun.wait, 60)
            other = asyncio.create_task(writer.execute(partial(written.append, "other")))
            late = asyncio.create_task(writer.execute(slow, within=0.05))
            await asyncio.sleep(0)
            store.gate.set()
            with pytest.raises(DatabaseUnavailable):
                await late
            gate.set()
            await asyncio.gather(first, other)
        # Once for nothing, in the transaction that was given up.
        assert [what for what in written if what != "slow"] == ["first", "other", "other"]
        assert len(store.durable) == 2

    asyncio.run(story())


def test_what_is_owed_to_the_disk_is_paid_in_a_lull_or_by_what_follows():
    async def story():
        store = Store()
        async with writing(store) as writer:
            await writer.execute(partial(int, "1"), is_durable=False)
            await writer.execute(partial(int, "2"), is_durable=False, is_owed=True)
            await eventually(lambda: store.durable == [False, False, "flush"])
            store.gate.clear()
            store.has_begun.clear()
            first = asyncio.create_task(writer.execute(partial(int, "3"), is_durable=False))
            await asyncio.to_thread(store.has_begun.wait, 60)
            owed = writer.execute(partial(int, "4"), is_durable=False, is_owed=True)
            together = [
                asyncio.create_task(work) for work in (owed, writer.execute(partial(int, "5")))
            ]
            await asyncio.sleep(0)
            store.gate.set()
            await asyncio.gather(first, *together)
            await writer.execute(partial(int, "6"), is_durable=False)
        assert store.durable[3:] == [False, True, False]

    asyncio.run(story())


def test_what_is_owed_is_paid_before_the_end():
    async def story():
        store = Store()
        async with writing(store) as writer:
            await writer.execute(partial(int, "1"), is_durable=False, is_owed=True)
        assert store.durable == [False, "flush"]

    asyncio.run(story())


def test_a_disk_that_refuses_what_is_owed_gets_it_again(monkeypatch):
    monkeypatch.setattr(module, "_AGAIN", 0.001)

    async def story():
        store = Store()
        store.num_full = 3
        async with writing(store) as writer:
            await writer.execute(partial(int, "1"), is_durable=False, is_owed=True)
            await eventually(lambda: store.durable == [False, "flush"])
            assert store.num_full == 0

    asyncio.run(story())
