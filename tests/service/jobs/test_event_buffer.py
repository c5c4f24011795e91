"""Events are recorded in order, each once, and what is not recorded by the end is given back."""

import asyncio

import pytest

from service.jobs import event_buffer as module
from service.jobs.event_buffer import EventBuffer
from service.jobs.json_text import Encoded


def events(count, first=0):
    return [("note", Encoded(str(i))) for i in range(first, first + count)]


def put(buffer, *told):
    for kind, data in told:
        buffer.put(kind, data)


class Gated:
    """Records events once a gate is open."""

    def __init__(self):
        self.recorded, self.gate = [], asyncio.Event()

    async def __call__(self, some):
        await self.gate.wait()
        self.recorded.extend(some)


def test_what_comes_just_before_the_end_is_given_back_without_a_wait():
    async def story():
        recorded = []
        buffer = EventBuffer(recorded.append)
        put(buffer, *events(3))
        closing = buffer.close()
        with pytest.raises(StopIteration) as ended:
            closing.send(None)  # it never gives way to the loop
        assert ended.value.value == events(3)
        await asyncio.sleep(2 * module._GATHERING)
        assert recorded == []

    asyncio.run(story())


def test_every_event_is_recorded_once_and_in_order_or_given_back():
    async def story():
        record = Gated()
        buffer = EventBuffer(record)
        put(buffer, *events(3))
        await asyncio.sleep(2 * module._GATHERING)  # they are being recorded
        put(buffer, *events(2, first=3))
        closing = asyncio.create_task(buffer.close())
        await asyncio.sleep(0)
        assert not closing.done()
        record.gate.set()
        left = await closing
        assert [*record.recorded, *left] == events(5)
        assert record.recorded[:3] == events(3)
        put(buffer, *events(1, first=9))  # too late
        assert await buffer.close() == left

    asyncio.run(story())


@pytest.mark.parametrize("is_writing", [False, True])
def test_a_flush_records_at_once_what_was_taken_before_it(is_writing, monkeypatch):
    monkeypatch.setattr(module, "_GATHERING", 3600.0)

    async def story():
        record = Gated()
        buffer = EventBuffer(record)
        put(buffer, *events(2))
        if is_writing:
            early = asyncio.create_task(buffer.flush())
            await asyncio.sleep(0)
            put(buffer, *events(2, first=2))
        flush = asyncio.create_task(buffer.flush())
        await asyncio.sleep(0.01)
        assert not flush.done()
        record.gate.set()
        await asyncio.wait_for(flush, 10)
        assert record.recorded == events(4 if is_writing else 2)
        if is_writing:
            await early
        await asyncio.wait_for(buffer.flush(), 10)  # there is nothing more
        assert await buffer.close() == []

    asyncio.run(story())


def test_a_flush_does_not_wait_for_a_database_that_refuses(monkeypatch):
    monkeypatch.setattr(module, "is_of_database", lambda _: True)

    async def story():
        async def refuse(some):
            raise OSError(str(some))

        buffer = EventBuffer(refuse)
        put(buffer, *events(2))
        await asyncio.wait_for(buffer.flush(), 10)
        await asyncio.wait_for(buffer.flush(), 10)
        assert await buffer.close() == events(2)

    asyncio.run(story())
