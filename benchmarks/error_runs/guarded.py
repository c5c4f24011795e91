"""Refusals of servers with settings of their own: keys, limits of time, drivers, robots' files."""

import json
import os
import signal
import socket
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from typer.testing import CliRunner

from benchmarks.error_runs.asking import Asking
from benchmarks.error_runs.made import Made
from benchmarks.error_runs.serving import ARM, arm_plan, asked, endless_plan
from service.cli.app import app
from tests.contracts.rtde_stub import RtdeStub

_MODELS = "/v1/models"
_HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
_PROTECTIVE_STOP = 3
# A link of less than no mass: Drake would take it.
_OF_NO_MASS = """<robot name="r">
  <link name="base"/>
  <link name="link"><inertial><mass value="-1"/></inertial></link>
  <joint name="j" type="revolute">
    <parent link="base"/><child link="link"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>
"""


def guarded() -> Iterator[Made]:
    """Yield what is refused so."""
    yield from _keys()
    with asked({"WAYPROOF_RATE_LIMIT": "2/minute"}, ready=False) as (asking, _):
        while (problem := asking.json("GET", _MODELS)).get("code") is None:
            pass
        yield Made("rate_limited", f"GET {_MODELS}", None, problem)
    yield _not_ready()
    yield _request_timeout()
    yield _server_stopping()
    with asked({}) as (asking, _):
        yield _revision_mismatch(asking)
        yield _model_invalid(asking)
    yield from _driver_lost()


def _keys() -> Iterator[Made]:
    with TemporaryDirectory(prefix="wayproof-errors-") as folder:
        create = ["keys", "create", "viewer", "--scope", "read", "--data-dir", folder]
        key = CliRunner().invoke(app, create).stdout.strip()
        with asked({"WAYPROOF_AUTH": "keys"}, Path(folder)) as (asking, _):
            yield Made("unauthorized", f"GET {_MODELS}", None, asking.json("GET", _MODELS))
            reading = Asking(asking.url, {"Authorization": f"Bearer {key}"})
            problem = reading.json("POST", "/v1/scenes", ARM)
            yield Made("scope_missing", "POST /v1/scenes", ARM, problem)


def _not_ready() -> Made:
    """Ask before the first worker is warm."""
    with asked({}, ready=False) as (asking, _):
        return Made("not_ready", "GET /readyz", None, asking.json("GET", "/readyz"))


def _request_timeout() -> Made:
    """Send a body that does not end."""
    with asked({"WAYPROOF_BODY_TIMEOUT": "0.5"}, ready=False) as (asking, _):
        url = asking.http.base_url
        with socket.create_connection((url.host, url.port)) as connection:
            head = f"POST /v1/plans HTTP/1.1\r\nHost: {url.host}\r\nContent-Length: 99\r\n"
            head += "Content-Type: application/json\r\n\r\n{"
            connection.sendall(head.encode())
            told = b""
            while part := connection.recv(4096):
                told += part
    problem = json.loads(told.partition(b"\r\n\r\n")[2])
    return Made("request_timeout", "POST /v1/plans", None, problem)


def _server_stopping() -> Made:
    """Ask a server that was told to end and waits for a plan."""
    with asked({"WAYPROOF_DRAIN_SECONDS": "60"}) as (asking, server):
        body = arm_plan(asking.scene(ARM))
        plan = endless_plan(asking)
        os.kill(server.pid, signal.SIGTERM)
        while (problem := asking.json("POST", "/v1/plans", body)).get("code") is None:
            pass
        asking.done("POST", f"/v1/plans/{plan}/cancel")
    return Made("server_stopping", "POST /v1/plans", body, problem)


def _revision_mismatch(asking: Asking) -> Made:
    """Edit a scene that another client has edited meanwhile."""
    scene = asking.scene(ARM)
    path = f"/v1/scenes/{scene}"
    tag = asking.http.get(path).headers["ETag"]
    thing = {"name": "thing", "shape": {"box": [0.1, 0.1, 0.1]}}
    body = {"operations": [{"op": "add", "object": thing}]}
    asking.done("PATCH", path, body)
    headers = {"If-Match": tag}
    problem = asking.http.patch(path, json=body, headers=headers).json()
    return Made("revision_mismatch", f"PATCH {path}", body, problem, headers=headers)


def _model_invalid(asking: Asking) -> Made:
    """Post a scene whose robot has a fault in its description."""
    with TemporaryDirectory(prefix="wayproof-errors-") as folder:
        file = Path(folder) / "robot.urdf"
        file.write_text(_OF_NO_MASS, encoding="utf-8")
        body = {"robots": [{"name": "r", "model": str(file)}]}
        problem = asking.json("POST", "/v1/scenes", body)
    shown = json.loads(json.dumps([body, problem]).replace(folder, "/robots/mine"))
    return Made("model_invalid", "POST /v1/scenes", *shown)


def _driver_lost() -> Iterator[Made]:
    """Have a controller stop its robot while it moves, and ask for another motion then."""
    stub = RtdeStub(_HOME)
    hosts = json.dumps({"cell-1": f"127.0.0.1:{stub.ports[0]}:{stub.ports[1]}"})
    try:
        with asked({"WAYPROOF_UR_HOSTS": hosts}) as (asking, _):
            plan = asking.planned(arm_plan(asking.scene(ARM)))
            driver = {"type": "ur_rtde", "host": "cell-1"}
            body = {"plan": plan["id"], "driver": driver, "speed": 0.01}
            execution = asking.done("POST", "/v1/executions", body)["id"]
            asking.moving(execution)
            stub.safety_mode = _PROTECTIVE_STOP
            failure = asking.ended(execution)["failure"]
            yield Made("driver_lost", "POST /v1/executions", body, failure)
            body = {"plan": plan["id"]}
            problem = asking.json("POST", "/v1/executions", body)
            yield Made("robot_state_unknown", "POST /v1/executions", body, problem)
    finally:
        stub.close()
