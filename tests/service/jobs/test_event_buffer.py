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
        recorded, gate = [], asyncio.Event()

        async def record(some):
            await gate.wait()
            recorded.extend(some)

        buffer = EventBuffer(record)
        put(buffer, *events(3))
        await asyncio.sleep(2 * module._GATHERING)  # they are being recorded
        put(buffer, *events(2, first=3))
        closing = asyncio.create_task(buffer.close())
        await asyncio.sleep(0)
        assert not closing.done()
        gate.set()
        left = await closing
        assert [*recorded, *left] == events(5)
        assert recorded[:3] == events(3)
        put(buffer, *events(1, first=9))  # too late
        assert await buffer.close() == left

    asyncio.run(story())
