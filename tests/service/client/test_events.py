"""Server-sent events are read as the standard says."""

from service.client.events import Event, decode_events

STREAM = """\
: a comment

event: stage
data: {"stage": "goals"}
id: 3

data: {}

event: nothing

id: 5
event: finished
data: {"state": "succeeded"}

"""


def test_events_are_decoded_and_the_rest_is_skipped():
    assert list(decode_events(STREAM.splitlines())) == [
        Event("3", "stage", {"stage": "goals"}),
        Event("", "", {}),
        Event("5", "finished", {"state": "succeeded"}),
    ]
