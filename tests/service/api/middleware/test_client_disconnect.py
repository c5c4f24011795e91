"""A question ends when its client leaves; what it waited and worked is told."""

import asyncio
import json
import threading

import pytest

from planning.errors import Canceled
from service.api.middleware.client_disconnect import (
    DisconnectWatch,
    call_for_client,
    unless_client_leaves,
)
from service.errors import ClientLeft
from service.jobs.dispatch.calls import CallResult
from service.queries.tasks import CHECK

# Against tests that hang.
GUARD = 20
EMPTY = {"type": "http.request", "body": b"", "more_body": False}
GONE = {"type": "http.disconnect"}


def asked(endpoint, told):
    """What an app answers to a client that tells so much, one after the other, and then waits."""
    sent = []

    async def receive():
        return told.pop(0) if told else await asyncio.Event().wait()

    async def send(message):
        sent.append(message)

    async def story():
        async with asyncio.timeout(GUARD):
            await DisconnectWatch(endpoint)({"type": "http"}, receive, send)

    asyncio.run(story())
    return sent


@pytest.mark.parametrize("before", [[], [EMPTY]])
def test_work_is_canceled_once_its_client_has_left(before):
    ended = []

    async def work():
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("work")

    async def endpoint(*_):
        with pytest.raises(ClientLeft):
            await unless_client_leaves(work())
        assert ended == ["work"]
        ended.append("told")

    asked(endpoint, [*before, GONE])
    assert ended == ["work", "told"]


def test_the_answer_comes_while_the_client_waits_and_says_what_it_took():
    async def work(waited, worked):
        for _ in range(10):
            await asyncio.sleep(0)
        return CallResult(3, waited, worked)

    async def endpoint(_, __, send):
        assert (await call_for_client(work(0.5, 0.25))).content == 3
        await call_for_client(work(0.25, 0.25))
        await send({"type": "http.response.start", "status": 200, "headers": []})

    [start] = asked(endpoint, [EMPTY])
    assert start["headers"] == [(b"server-timing", b"queue;dur=750.0, work;dur=500.0")]


def test_what_asks_nothing_has_no_timing():
    async def endpoint(_, __, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})

    assert asked(endpoint, []) == [{"type": "http.response.start", "status": 200, "headers": []}]


def test_a_question_without_a_request_is_just_asked():
    async def work():
        return 3

    assert asyncio.run(unless_client_leaves(work())) == 3


def test_a_client_that_leaves_ends_its_question_in_its_slot(client, app, scene, monkeypatch):
    begun, ended = threading.Event(), threading.Event()

    def endless(_, channel):
        begun.set()
        while not channel.is_canceled():
            threading.Event().wait(0.001)
        ended.set()
        raise Canceled("noticed")

    path = f"/v1/scenes/{scene}/check"
    body = {"group": "arm", "configurations": [[0.0] * 6]}
    told = [{**EMPTY, "body": json.dumps(body).encode()}]

    async def receive():
        if told:
            return told.pop()
        assert await asyncio.to_thread(begun.wait, GUARD), "the question never began"
        return GONE

    async def send(message):
        statuses.append(message.get("status"))

    statuses = []
    headers = [(b"host", b"testserver"), (b"content-type", b"application/json")]
    headers += [(b"content-length", str(len(told[0]["body"])).encode())]
    scope = {"type": "http", "method": "POST", "path": path, "raw_path": path.encode()}
    scope |= {"headers": headers, "query_string": b"", "http_version": "1.1", "scheme": "http"}
    scope |= {"root_path": "", "server": ("testserver", 80), "client": ("test", 1), "app": app}
    with monkeypatch.context() as patch:
        patch.setattr(CHECK, "_function", endless)
        client.portal.call(app, scope, receive, send)
        assert statuses[0] == 499
        assert ended.wait(GUARD)
    answer = client.post(path, json=body)
    assert answer.is_success
    assert answer.headers["server-timing"].startswith("queue;dur=")
