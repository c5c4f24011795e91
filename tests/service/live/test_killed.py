"""Servers as users run them: what is killed in mid-motion leaves the robot where it was last."""

import json
import os
import signal
import socket
from urllib.parse import urlsplit

import httpx
import pytest
from wsproto import ConnectionType, WSConnection
from wsproto.events import AcceptConnection, CloseConnection, RejectConnection, Request, TextMessage

from tests.profiles import only_campaign
from tests.service.live.test_state import CELL, NEAR
from tests.service.servers import PLAIN, living, server, until
from tests.service.successor import successor


@pytest.fixture(scope="module")
def running(tmp_path_factory):
    with server(tmp_path_factory.mktemp("live"), WAYPROOF_HEADER_TIMEOUT="1") as made:
        yield made


def plan_in(asked, scene, goal=NEAR):
    request = {"scene": scene, "group": "body", "goal": {"type": "joint", "positions": goal}}
    job = asked.ask("POST", "/v1/plans?wait=60", request)
    assert job["state"] == "succeeded", job["failure"]
    return job


def moving(asked, scene):
    """The id of an execution that is on its way."""
    plan = plan_in(asked, scene)["id"]
    execution = asked.ask("POST", "/v1/executions", {"plan": plan, "speed": 0.05})["id"]
    path = f"/v1/executions/{execution}"
    until(lambda: (status := asked.ask("GET", path)["status"]) and status["progress"] > 0.05)
    return execution


def state_of(asked, scene):
    return asked.ask("GET", f"/v1/scenes/{scene}/state")["robots"][0]


def check_left(asked, scene, execution):
    """Check that the robot rests where it was measured last, and goes on from there."""
    ended = asked.ask("GET", f"/v1/executions/{execution}")
    assert ended["state"] == "aborted", ended
    left = state_of(asked, scene)
    assert left["status"] == "at_rest"
    assert left["execution"] is None
    assert left["source"] == {"type": "execution", "id": execution}
    assert left["positions"]["base_joint"] == ended["status"]["positions"]
    assert left["positions"]["base_joint"][0] > CELL["robots"][0]["positions"][0]
    assert asked.ask("GET", f"/v1/scenes/{scene}")["revision"] == 1
    onward = plan_in(asked, scene)
    assert onward["result"]["start"] == left["positions"]["base_joint"]
    done = asked.ask("POST", "/v1/executions?wait=60", {"plan": onward["id"], "speed": 50})
    assert done["state"] == "succeeded", done


def test_a_worker_that_is_killed_leaves_the_robot_where_it_was_measured_last(running):
    scene = running.ask("POST", "/v1/scenes", CELL)["id"]
    execution = moving(running, scene)
    for pid in workers_of(running.process.pid):
        os.kill(pid, signal.SIGKILL)
    path = f"/v1/executions/{execution}"
    until(lambda: running.ask("GET", path)["finished_at"])
    check_left(running, scene, execution)


def workers_of(pid):
    return [child for child, parent in living().items() if parent == pid]


@only_campaign("a server starts twice: 12 s")
def test_a_server_that_is_killed_leaves_the_robot_where_it_was_measured_last(tmp_path):
    with server(tmp_path) as killed:
        scene = killed.ask("POST", "/v1/scenes", CELL)["id"]
        execution = moving(killed, scene)
        killed.kill()
    with successor(tmp_path) as restarted:
        check_left(restarted, scene, execution)


def test_the_stream_of_a_server_shows_movement_while_it_happens(running):
    scene = running.ask("POST", "/v1/scenes", CELL)["id"]
    execution = moving(running, scene)
    with httpx.stream(
        "GET", f"{running.url}/v1/scenes/{scene}/state/events?rate=100", timeout=120, **PLAIN
    ) as answer:
        told = (
            json.loads(line.removeprefix("data: "))["robots"][0]
            for line in answer.iter_lines()
            if line.startswith("data: ")
        )
        first = next(told)
        assert (first["status"], first["execution"]) == ("moving", execution)
        running.ask("POST", f"/v1/executions/{execution}/cancel")
        last = next(state for state in told if state["status"] == "at_rest")
    assert last == state_of(running, scene)
    assert last["positions"]["base_joint"][0] > first["positions"]["base_joint"][0]


def test_a_websocket_of_a_server_outlives_the_time_for_headers(running):
    """It was cut off after it, as a request that does not go on."""
    scene = running.ask("POST", "/v1/scenes", CELL)["id"]
    with WebSocketClient(running.url, f"/v1/scenes/{scene}/state/ws") as client:
        first = json.loads(client.receive())
        assert first["data"] == running.ask("GET", f"/v1/scenes/{scene}/state")
        assert client.receives_nothing_for(1.5)  # and the headers had a second
        place = {"op": "set_positions", "robot": "body", "positions": NEAR}
        running.ask("PATCH", f"/v1/scenes/{scene}", {"operations": [place]})
        assert json.loads(client.receive())["data"]["revision"] == 2
        running.ask("POST", "/v1/scenes", CELL)
        assert httpx.delete(f"{running.url}/v1/scenes/{scene}", **PLAIN).status_code == 204
        assert client.receive() is None


@pytest.mark.parametrize(
    ("scene", "headers", "status"),
    [("scn_nothing", [], 404), (None, [(b"origin", b"http://elsewhere.example")], 403)],
)
def test_a_websocket_is_refused_before_it_is_one(running, scene, headers, status):
    known = scene or running.ask("POST", "/v1/scenes", CELL)["id"]
    with pytest.raises(ConnectionRefusedError, match=str(status)):
        WebSocketClient(running.url, f"/v1/scenes/{known}/state/ws", headers)


class WebSocketClient:
    """A client of RFC 6455 on a socket of its own."""

    def __init__(self, url, path, headers=()):
        address = urlsplit(url)
        self._socket = socket.create_connection((address.hostname, address.port), timeout=60)
        self._wire = WSConnection(ConnectionType.CLIENT)
        self._events = iter(())
        request = Request(host=address.netloc, target=path, extra_headers=list(headers))
        self._socket.sendall(self._wire.send(request))
        answer = self._next()
        if isinstance(answer, RejectConnection):
            self._socket.close()
            raise ConnectionRefusedError(str(answer.status_code))
        assert isinstance(answer, AcceptConnection)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._socket.close()

    def receive(self):
        """The next text; None once the server has closed."""
        text = ""
        while True:
            event = self._next()
            if isinstance(event, CloseConnection):
                return None
            if isinstance(event, TextMessage):
                text += event.data
                if event.message_finished:
                    return text

    def receives_nothing_for(self, seconds):
        self._socket.settimeout(seconds)
        try:
            return self.receive() is not None and False
        except TimeoutError:
            return True
        finally:
            self._socket.settimeout(60)

    def _next(self):
        while (event := next(self._events, None)) is None:
            self._wire.receive_data(self._socket.recv(65536) or None)
            self._events = self._wire.events()
        return event
