"""Followers see every number once, in order, however slow they are and whenever they come."""

import asyncio
from contextlib import aclosing
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.event_bus import TAIL_LENGTH, EventBatch, EventBus


@dataclass(frozen=True)
class Note:
    number: int
    is_last: bool = False


class Log:
    """A record that is read with a pause in between, as databases are."""

    def __init__(self):
        self.notes = []
        self.num_reads = 0

    async def read(self, _, after):
        self.num_reads += 1
        is_over = bool(self.notes) and self.notes[-1].is_last
        await asyncio.sleep(0)
        found = [note for note in self.notes if note.number > after][:5]
        await asyncio.sleep(0)
        return EventBatch(found, is_over)

    def add(self, bus, count, *, is_last=False):
        first = len(self.notes) + 1
        new = [Note(first + i, is_last and i == count - 1) for i in range(count)]
        self.notes += new
        bus.publish("s", new)


async def follow(bus, after=0, pauses=0):
    seen = []
    async for note in bus.follow("s", after):
        seen.append(note.number)
        for _ in range(pauses):
            await asyncio.sleep(0)
    return seen


@given(
    batches=st.lists(st.integers(1, 40), min_size=1, max_size=20),
    followers=st.lists(
        st.tuples(st.integers(0, 30), st.integers(0, 12), st.integers(0, 6)), max_size=6
    ),
)
def test_no_number_is_lost_or_repeated(batches, followers):
    async def story():
        log = Log()
        bus = EventBus(log.read)

        async def late(after, joins, pauses):
            for _ in range(joins):
                await asyncio.sleep(0)
            return await follow(bus, after, pauses)

        tasks = [asyncio.create_task(late(*follower)) for follower in followers]
        for i, count in enumerate(batches):
            await asyncio.sleep(0)
            log.add(bus, count, is_last=i == len(batches) - 1)
        total = sum(batches)
        for (after, _, _), task in zip(followers, tasks, strict=True):
            assert await task == list(range(after + 1, total + 1))
        assert bus.num_streams == 0

    asyncio.run(story())


def test_a_follower_slower_than_the_tail_reads_the_log():
    async def story():
        log = Log()
        bus = EventBus(log.read)
        slow = asyncio.create_task(follow(bus, pauses=3))
        for _ in range(4):
            await asyncio.sleep(0)
            log.add(bus, TAIL_LENGTH)
        log.add(bus, 1, is_last=True)
        assert await slow == list(range(1, 4 * TAIL_LENGTH + 2))
        assert log.num_reads > 1

    asyncio.run(story())


def test_many_followers_that_keep_up_read_the_log_once_each():
    async def story():
        log = Log()
        bus = EventBus(log.read)
        tasks = [asyncio.create_task(follow(bus)) for _ in range(50)]
        for _ in range(5):
            await asyncio.sleep(0)
        for _ in range(20):
            log.add(bus, 1)
            await asyncio.sleep(0)
        log.add(bus, 1, is_last=True)
        assert {tuple(await task) for task in tasks} == {tuple(range(1, 22))}
        assert log.num_reads <= 100

    asyncio.run(story())


@pytest.mark.parametrize("after", [3, 4, 1000])
def test_following_what_is_over_ends(after):
    async def story():
        log = Log()
        bus = EventBus(log.read)
        log.add(bus, 3, is_last=True)
        assert await follow(bus, after) == []
        assert bus.num_streams == 0

    asyncio.run(story())


def test_a_number_from_nowhere_ends_with_the_stream():
    async def story():
        log = Log()
        bus = EventBus(log.read)
        lost = asyncio.create_task(follow(bus, 1000))
        await asyncio.sleep(0)
        log.add(bus, 3, is_last=True)
        assert await lost == []

    asyncio.run(story())


def test_closing_ends_followers_and_leaving_forgets_them():
    async def story():
        log = Log()
        bus = EventBus(log.read)
        waiting = asyncio.create_task(follow(bus))
        log.add(bus, 2)
        async with aclosing(bus.follow("other")) as other:
            step = asyncio.create_task(anext(other, None))
            for _ in range(5):
                await asyncio.sleep(0)
            assert bus.num_streams == 2
            bus.close()
            assert await waiting == [1, 2]
            await step
        assert bus.num_streams == 1  # the one that goes on

    asyncio.run(story())


@given(
    writers=st.lists(st.tuples(st.booleans(), st.integers(1, 5)), min_size=1, max_size=30),
    after=st.integers(0, 8),
)
def test_what_another_server_records_is_read_once_followers_are_woken(writers, after):
    """Some is published here; the rest is in the log only, and this server hears that it is."""

    async def story():
        log = Log()
        bus = EventBus(log.read)
        seen = asyncio.create_task(follow(bus, after))
        over = asyncio.create_task(bus.until_over("s"))
        await asyncio.sleep(0)
        for i, (is_here, count) in enumerate(writers):
            is_last = i == len(writers) - 1
            log.add(bus if is_here or is_last else Elsewhere(bus), count, is_last=is_last)
            for _ in range(i % 4):
                await asyncio.sleep(0)
        async with asyncio.timeout(60):
            assert await seen == list(range(after + 1, len(log.notes) + 1))
            await over
        assert bus.num_streams == 0

    asyncio.run(story())


class Elsewhere:
    """Another server, which notifies this one of events."""

    def __init__(self, bus):
        self._bus = bus

    def publish(self, stream, _):
        self._bus.wake(stream)
