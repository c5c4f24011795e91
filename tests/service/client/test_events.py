"""Server-sent events are read as the standard says, however the network cuts them."""

import httpx
import pytest
from httpx_sse import SSEError

from service.client.events import Event, decode_events

STREAM = """\
: a comment

event: stage
data: {"stage": "goals",
data:  "progress": 0.5}
id: 3

data: {}

event: nothing

id: 5
event: finished
data: {"name": "Greifer\u2028\u00fc"}

"""
EVENTS = [
    Event("3", "stage", {"stage": "goals", "progress": 0.5}),
    Event("3", "message", {}),
    Event("5", "finished", {"name": "Greifer\u2028\u00fc"}),
]


def response(text, step, media_type="text/event-stream"):
    octets = text.encode()
    pieces = (octets[i : i + step] for i in range(0, len(octets), step))
    return httpx.Response(200, headers={"content-type": media_type}, content=pieces)


@pytest.mark.parametrize("step", [1, 7, 10_000])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_events_are_decoded_and_the_rest_is_skipped(step, newline):
    assert list(decode_events(response(STREAM.replace("\n", newline), step))) == EVENTS


def test_what_is_no_stream_is_an_error():
    with pytest.raises(SSEError, match="text/event-stream"):
        list(decode_events(response("{}", 10, "application/json")))
