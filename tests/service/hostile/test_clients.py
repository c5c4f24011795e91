"""Whatever a client sends, it gets the right answer or none, and the next one gets its own."""

import re
import socket
from urllib.parse import urlsplit

import httpx
import pytest

from tests.service.hostile.clients import CLIENTS
from tests.service.hostile.test_bodies import tells_of_the_server
from tests.service.servers import PLAIN

# Against tests that hang.
GUARD = 60


def answer_to(server, sent):
    """All that comes until the server closes the connection, or has answered in full."""
    url = urlsplit(server.url)
    with socket.create_connection((url.hostname, url.port), GUARD) as connection:
        parts = []
        try:
            connection.sendall(sent)
            while part := connection.recv(65_536):
                parts.append(part)
        except (BrokenPipeError, ConnectionResetError):  # it has heard enough
            pass
    return b"".join(parts)


@pytest.mark.parametrize("name", CLIENTS)
def test_the_answer_is_right(real_server, name):
    sent, statuses = CLIENTS[name]
    answer = answer_to(real_server, sent)
    if answer:
        found = {int(status) for status in re.findall(rb"^HTTP/1.1 (\d+)", answer, re.MULTILINE)}
        assert found & statuses, answer[:500]
        assert not tells_of_the_server(answer.decode("utf-8", "replace"), real_server.folder)
    assert b"root:" not in answer
    assert httpx.get(f"{real_server.url}/healthz", **PLAIN).is_success
