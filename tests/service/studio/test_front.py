"""The studio's front: who gets the page and the WebSocket, and that messages pass as they are."""

import threading
import warnings
from contextlib import contextmanager

import pytest
from starlette.applications import Starlette
from starlette.websockets import WebSocketDisconnect
from websockets.sync.server import serve

from service.api.middleware.host_check import HostCheck
from service.settings import Settings
from service.studio import front

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient

_TOKEN = "only-the-two-know-it"
_VISER = ["viser-v0"]


@contextmanager
def echo(seen):
    """A server in place of the studio's process: it notes headers and sends back what comes."""

    def answer(connection):
        seen.append(connection.request.headers)
        for message in connection:
            connection.send(message[::-1])

    with serve(answer, "127.0.0.1", 0, subprotocols=_VISER, max_size=None) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.socket.getsockname()[1]
        server.shutdown()


def app_of(upstream, *, is_server=True):
    app = Starlette()
    front.install(app, upstream, is_server=is_server)
    app.add_middleware(HostCheck, settings=Settings(engine="inline"))
    return TestClient(app)


@pytest.fixture
def seen():
    return []


@pytest.fixture
def client(seen):
    with echo(seen) as port:

        async def upstream():
            return port, _TOKEN

        yield app_of(upstream)


def test_messages_pass_both_ways_in_order_and_whole(client, seen):
    with client.websocket_connect("/", subprotocols=_VISER) as browser:
        assert browser.accepted_subprotocol == _VISER[0]
        large = bytes(range(256)) * 20_000
        for sent in (b"abc", large, b"\x00\x01"):
            browser.send_bytes(sent)
            assert browser.receive_bytes() == sent[::-1]
    (headers,) = seen
    assert headers[front.TOKEN_HEADER] == _TOKEN
    assert headers[front.HOST_HEADER] == "testserver"


@pytest.mark.parametrize(
    "headers",
    [{"Origin": "https://evil.example"}, {"Host": "evil.example"}, {"Origin": "null"}],
)
def test_pages_of_others_get_no_socket(client, seen, headers):
    with (
        pytest.raises(Exception) as refused,
        client.websocket_connect("/", subprotocols=_VISER, headers=headers),
    ):
        pass
    assert "Disconnect" in type(refused.value).__name__ or "Denial" in type(refused.value).__name__
    assert seen == []


def test_the_own_page_gets_one(client, seen):
    own = {"Origin": "http://testserver"}
    with client.websocket_connect("/", subprotocols=_VISER, headers=own) as browser:
        browser.send_bytes(b"ab")
        assert browser.receive_bytes() == b"ba"


def test_the_page_is_ours_needs_no_other_host_and_may_ask_none(client):
    page = client.get("/")
    assert "<title>Wayproof studio</title>" in page.text
    assert "rx='7'" in page.text  # our icon
    policy = page.headers["content-security-policy"]
    assert "connect-src 'self' data: blob:;" in policy
    assert "default-src 'none'" in policy
    assert "http" not in policy


def test_a_studio_that_does_not_start_closes_the_socket():
    async def upstream():
        message = "the studio does not start"
        raise OSError(message)

    client = app_of(upstream)
    with client.websocket_connect("/", subprotocols=_VISER) as browser:
        with pytest.raises(WebSocketDisconnect) as closed:
            browser.receive_bytes()
        assert closed.value.code == 1011


def test_no_more_browsers_than_there_is_room_for(client, monkeypatch):
    monkeypatch.setattr(front, "_MAX_BROWSERS", 1)
    with client.websocket_connect("/", subprotocols=_VISER) as first:
        first.send_bytes(b"ab")
        assert first.receive_bytes() == b"ba"
        with pytest.raises(WebSocketDisconnect), client.websocket_connect("/") as second:
            second.receive_bytes()
    with client.websocket_connect("/", subprotocols=_VISER) as third:  # it has left
        third.send_bytes(b"ab")
        assert third.receive_bytes() == b"ba"


def test_another_server_is_asked_by_its_address(seen):
    with echo(seen) as port:

        async def upstream():
            return port, _TOKEN

        with app_of(upstream, is_server=False).websocket_connect("/", subprotocols=_VISER) as one:
            one.send_bytes(b"ab")
            one.receive_bytes()
    assert seen[0][front.HOST_HEADER] == ""


def test_the_page_finds_out_whether_its_server_is_there(client):
    # what its script asks every other second is answered, and costs next to nothing
    page = client.get("/").text
    assert 'fetch("/", { method: "HEAD"' in page
    assert client.head("/").status_code == 200
    assert client.head("/").content == b""
