"""The stream of the live state: it moves with the robot, and slow readers hold nothing up."""

import asyncio
import itertools
import json
from contextlib import aclosing, contextmanager
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import pytest

from service.client.events import decode_events
from service.errors import UnknownResource
from service.jobs.event_bus import EventBatch, EventBus
from service.jobs.job import LoggedEvent
from service.live import feed as feeds
from service.live.feed import LiveFeeds, Watch
from service.scenes.live import DocumentSource, Motion, RobotState, RobotStatus
from tests.service.live.test_state import (
    CELL,
    NEAR,
    begun,
    edited,
    finished,
    moved,
    planned,
    positions,
    posted,
    state_of,
)


@pytest.fixture
def scene(client):
    return posted(client, CELL)


def streamed(client, scene, query="", **headers):
    with client.stream("GET", f"/v1/scenes/{scene}/state/events{query}", headers=headers) as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        return list(decode_events(answer))


def body_of(event):
    return event.data["robots"][0]


def test_the_first_event_is_the_state_as_it_is(client, scene):
    (event,) = streamed(client, scene, "?most=1")
    assert (event.type, body_of(event)) == ("state", state_of(client, scene))
    assert event.data == client.get(f"/v1/scenes/{scene}/state").json()


def test_the_stream_shows_how_the_robot_moves(client, scene):
    path = begun(client, planned(client, scene, NEAR), speed=0.1)
    events = streamed(client, scene, "?most=6&rate=100")
    client.post(f"{path}/cancel")
    finished(client, path)
    assert {body_of(event)["status"] for event in events} == {"moving"}
    assert {body_of(event)["execution"] for event in events} == {path.rsplit("/", 1)[1]}
    way = [positions(body_of(event))[0] for event in events]
    assert way == sorted(set(way))  # it goes to the right, and nothing is told twice
    ids = [int(event.id) for event in events]
    assert ids == sorted(set(ids))


def test_what_was_seen_is_not_sent_again(client, scene):
    (first,) = streamed(client, scene, "?most=1")
    moved(client, scene, NEAR)
    headers = {"Last-Event-ID": first.id}
    (now,) = streamed(client, scene, "?most=1", **headers)
    assert int(now.id) > int(first.id)
    assert body_of(now) == state_of(client, scene)
    (again,) = streamed(client, scene, "?most=1", **{"Last-Event-ID": "of another stream"})
    assert again.id == now.id


@pytest.mark.parametrize("query", ["?rate=0", "?rate=101", "?rate=nan", "?most=0", "?speed=1"])
def test_bad_parameters_are_refused(client, scene, query):
    assert client.get(f"/v1/scenes/{scene}/state/events{query}").status_code == 422


def test_of_a_scene_that_is_not_there_nothing_is_streamed(client):
    answer = client.get("/v1/scenes/scn_nothing/state/events")
    assert (answer.status_code, answer.json()["code"]) == (404, "not_found")


def test_a_websocket_sends_the_same(client, scene):
    (event,) = streamed(client, scene, "?most=1")
    with client.websocket_connect(f"/v1/scenes/{scene}/state/ws?rate=100") as socket:
        first = socket.receive_json()
        assert first == {"id": event.id, "event": "state", "data": event.data}
        edited(client, scene, {"op": "set_positions", "robot": "body", "positions": NEAR})
        second = socket.receive_json()
    assert int(second["id"]) > int(first["id"])
    assert positions(second["data"]["robots"][0]) == NEAR
    with client.websocket_connect(
        f"/v1/scenes/{scene}/state/ws?after={second['id']}&rate=100"
    ) as socket:
        edited(client, scene, {"op": "remove", "object": "post"})
        assert socket.receive_json()["data"]["revision"] == 3


# Of the feed alone: what several readers are told, and when.

MADE = datetime(2026, 1, 1, tzinfo=UTC)
BODY = RobotState("body", {"j": 0.0}, None, RobotStatus.AT_REST, DocumentSource(1), MADE)


class Record:
    """A revision of a scene in which one robot moves."""

    id, revision, created_at = "scn", 1, MADE
    summary = SimpleNamespace(groups=())

    def __init__(self, live, objects=()):
        self.live, self.document = live, {"objects": list(objects)}


class Cell:
    """The records of a scene, and the jobs that move something in it."""

    def __init__(self, *events):
        self.events = list(events)
        self.bus = EventBus(self._read)
        self.is_stopping = self.is_gone = False
        self.num_read = 0
        self.motions = [Motion("exe", "body", 1, ["body"], {"body::j": "revolute"}, MADE)]

    async def _read(self, stream, after):
        return EventBatch([each for each in self.events if each.number > after], is_over=False)

    async def at(self, identifier, motions):
        self.num_read += 1
        if self.is_gone:
            raise UnknownResource.of("scene", identifier)
        return Record({"body": BODY})

    @contextmanager
    def watch(self, name):
        with self.bus.watch(name) as change:
            yield change

    async def events_of(self, identifier, after):
        async for event in self.bus.follow(identifier, after):
            yield event

    def measure(self, value):
        number = len(self.events) + 1
        at = MADE + timedelta(seconds=number)
        data = {"positions": [value]}
        self.events.append(LoggedEvent("exe", number, "status", data, at.isoformat()))
        self.bus.publish("exe", self.events[-1:])


@pytest.fixture
def cell(monkeypatch):
    made = Cell()

    async def open_motions(scene, *, jobs):
        return made.motions

    monkeypatch.setattr(feeds, "open_motions", open_motions)
    return made


def value(told):
    return json.loads(told.text)["robots"][0]["positions"]["j"]


async def settled():
    for _ in range(20):
        await asyncio.sleep(0)


def test_a_slow_reader_gets_the_newest_and_holds_nothing_up(cell):
    async def play():
        all_feeds = LiveFeeds(cell, cell)
        slow = all_feeds.follow("scn", Watch(rate=1e9))
        quick = all_feeds.follow("scn", Watch(rate=1e9))
        async with aclosing(slow), aclosing(quick):
            seen = [value(await anext(slow))]
            told = [value(await anext(quick))]
            for number in range(1, 1001):
                cell.measure(float(number))
                told.append(value(await anext(quick)))
            seen.append(value(await anext(slow)))
            assert told == [float(number) for number in range(1001)]
            assert seen == [0.0, 1000.0]
            assert cell.num_read == 1  # for both, and not for each measurement
        assert all_feeds.num_feeds == 0

    asyncio.run(play())


def test_readers_are_told_no_more_often_than_they_wish(cell):
    async def play():
        clock = asyncio.get_running_loop().time
        async with aclosing(LiveFeeds(cell, cell).follow("scn", Watch(rate=20))) as states:
            await anext(states)
            begun_at = clock()
            for number in itertools.count(1):
                cell.measure(float(number))
                if number == 3:
                    break
                await anext(states)
            assert clock() - begun_at >= 2 / 20 - 0.001

    asyncio.run(play())


@pytest.mark.parametrize("end", ["is_gone", "is_stopping"])
def test_the_stream_ends_with_the_scene_and_with_the_server(cell, end):
    async def play():
        async with aclosing(LiveFeeds(cell, cell).follow("scn", Watch(rate=1e9))) as states:
            await anext(states)
            setattr(cell, end, True)
            cell.bus.wake("scn")
            with pytest.raises(StopAsyncIteration):
                await anext(states)

    asyncio.run(play())


def test_a_change_between_the_look_and_the_wait_is_not_missed(cell):
    async def play():
        at = cell.at

        async def at_and_change(*given):
            found = await at(*given)
            if cell.num_read == 1:
                cell.bus.wake("scn")
                cell.motions = []
            return found

        cell.at = at_and_change
        async with aclosing(LiveFeeds(cell, cell).follow("scn", Watch(rate=1e9))) as states:
            await anext(states)
            await settled()
            assert cell.num_read == 2

    asyncio.run(play())


def test_numbers_are_of_the_state_whichever_server_tells_it(cell):
    async def play():
        numbers = []
        for _ in range(2):
            async with aclosing(LiveFeeds(cell, cell).follow("scn", Watch(rate=1e9))) as states:
                numbers.append((await anext(states)).number)
        assert numbers[0] == numbers[1]
        async with aclosing(
            LiveFeeds(cell, cell).follow("scn", Watch(rate=1e9, seen=numbers[0]))
        ) as states:
            waiting = asyncio.ensure_future(anext(states))
            await settled()
            assert not waiting.done()
            cell.measure(1.0)
            assert value(await waiting) == 1.0

    asyncio.run(play())
