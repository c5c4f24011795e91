"""What the end of the server cuts off is answered, unless an answer has begun."""

import asyncio
import json

import pytest

from service.api.middleware.graceful_shutdown import GracefulShutdown

START = {"type": "http.response.start", "status": 200, "headers": []}
EVENTS = {**START, "headers": [(b"content-type", b"text/event-stream; charset=utf-8")]}
END = {"type": "http.response.body", "body": b"", "more_body": False}


def cut_off(app, *, is_stopping):
    """What a client gets of a request that is canceled while `app` works on it."""
    sent = []

    async def send(message):
        await asyncio.sleep(0)
        sent.append(message)

    async def story():
        around = GracefulShutdown(app, lambda: is_stopping)
        request = asyncio.create_task(around({"type": "http"}, None, send))
        await asyncio.sleep(0.01)
        request.cancel()
        await request

    try:
        asyncio.run(story())
    except asyncio.CancelledError:
        sent.append("canceled")
    return sent


async def waits(scope, receive, send):
    await asyncio.Event().wait()


async def answers(scope, receive, send):
    await send(START)
    await asyncio.Event().wait()


async def streams(scope, receive, send):
    await send(EVENTS)
    await asyncio.Event().wait()


def test_it_is_told_to_ask_again():
    start, body = cut_off(waits, is_stopping=True)
    headers = dict(start["headers"])
    assert start["status"] == 503
    assert int(headers[b"retry-after"]) > 0
    assert json.loads(body["body"])["code"] == "server_stopping"


def test_a_stream_of_events_ends():
    assert cut_off(streams, is_stopping=True) == [EVENTS, END]


@pytest.mark.parametrize(
    ("app", "is_stopping", "sent"),
    [
        (answers, True, [START, "canceled"]),
        (waits, False, ["canceled"]),
        (streams, False, [EVENTS, "canceled"]),
    ],
)
def test_nothing_is_added_to_an_answer_and_no_other_cancel_is_held_up(app, is_stopping, sent):
    assert cut_off(app, is_stopping=is_stopping) == sent
