"""A key that comes where none belongs, as in an address, is not written to the log."""

import subprocess
import sys

import pytest

from service.telemetry.masking import redacted

KEY = "wp_0123456789ab_" + "Sekret-_9" * 4 + "1234567"
# In a process of its own: to configure logging closes what pytest logs to.
WRITE = """
import logging, sys
from service.telemetry.logs import LogTerms, configure_logs
configure_logs(LogTerms("text", "info"))
key = sys.argv[1]
line = ("127.0.0.1:1", "GET", f"/v1/plans/{key}?cursor={key}", "1.1", 404)
logging.getLogger("uvicorn.access").info('%s - "%s %s HTTP/%s" %d', *line)
for name in ("uvicorn.error", "service.x", "wayproof.audit"):
    try:
        raise ValueError(key)
    except ValueError as fault:
        logging.getLogger(name).error(f"of {key}: %s", fault, exc_info=True)
"""


@pytest.fixture(scope="module")
def written():
    """The lines that the server writes."""
    command = [sys.executable, "-c", WRITE, KEY]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stderr.splitlines()


def test_what_is_left_tells_which_key_it_was():
    assert redacted(f"a {KEY} b {KEY}.") == "a wp_0123456789ab_... b wp_0123456789ab_...."
    assert redacted("wp_0123456789ab_short") == "wp_0123456789ab_short"


def test_the_log_of_requests_has_no_key(written):
    line = written[0]
    assert "path=/v1/plans/wp_0123456789ab_..." in line
    assert "404" in line
    assert "Sekret" not in line


def test_nor_has_any_other_line_or_traceback(written):
    assert len(written) == 4
    for line in written[1:]:
        assert "of wp_0123456789ab_...: wp_0123456789ab_..." in line
        assert "ValueError: wp_0123456789ab_..." in line
        assert "Sekret" not in line
