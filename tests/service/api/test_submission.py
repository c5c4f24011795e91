"""How long a client is willing to wait."""

import pytest

from service.api.submission import seconds_to_wait


@pytest.mark.parametrize(
    ("wait", "prefer", "seconds"),
    [
        (None, None, 0.0),
        (3.0, None, 3.0),
        (0.0, "wait=9", 0.0),
        (None, "wait=9", 9.0),
        (None, "respond-async, wait=2.5", 2.5),
        (None, "await=9", 0.0),
        (None, "wait=soon", 0.0),
        (99999.0, None, 60.0),
        (None, "wait=99999", 60.0),
    ],
)
def test_the_parameter_wins_and_the_server_bounds_it(wait, prefer, seconds):
    assert seconds_to_wait(wait, prefer, longest=60.0) == seconds
