"""Servers as users run them: processes of their own, asked over HTTP, killed and looked into."""

import json
import os
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

from service.client.client import Client

WALLED = b"""
name: walled
robots:
  - {name: body, model: planar_l, positions: [-0.35, -0.3, 0]}
objects:
  - {name: wall, shape: {box: [0.02, 9, 0.2]}, pose: {position: [0, 0, 0]}}
"""
# Without proxies, and without certificates, which take longer to read than most questions.
PLAIN = {"trust_env": False, "verify": False}
ARM = b"name: s\nrobots:\n  - {name: arm, model: ur5e, positions: home}\n"


@dataclass(frozen=True)
class Server:
    """A running server: its process, its folder, where it listens, and a client of it."""

    process: subprocess.Popen
    folder: Path
    url: str
    client: Client

    def ask(self, method, path, body=None):
        """The JSON of an answer that is no problem."""
        answer = httpx.request(method, self.url + path, json=body, timeout=120, **PLAIN)
        assert answer.is_success, answer.text
        return answer.json()

    @property
    def database(self):
        """The file of its records."""
        return self.folder / "state" / "wayproof.sqlite"

    def kill(self):
        """End it without a word."""
        self.process.kill()
        self.process.wait()


@contextmanager
def server(folder, log=subprocess.DEVNULL, port=0, module="service", **environment):
    """A server that keeps its records in `folder`, and may write its log to an open file.

    `module` is what runs instead of the service's own.
    """
    announce = folder / "announce.json"
    announce.unlink(missing_ok=True)
    command = [sys.executable, "-m", module, "serve", "--port", str(port), "--leashed"]
    command += ["--data-dir", str(folder / "state"), "--announce", str(announce)]
    # Beside other tests, plans that let everything else go before would hardly go on.
    chosen = os.environ | {"WAYPROOF_NICENESS": "0"} | environment
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=log, env=chosen)
    try:
        url = until(lambda: ready_url(announce))
        with Client(url) as client:
            yield Server(process, folder, url, client)
    finally:
        process.stdin.close()
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def until(ask, seconds=120.0):
    """The first answer that is true; the time limit is for what hangs, whatever the machine."""
    pause = threading.Event()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := ask():
            return found
        pause.wait(0.05)
    pytest.fail("waited in vain")


def ready_url(announce):
    try:
        url = json.loads(announce.read_text())["url"]
        return url if httpx.get(f"{url}/readyz", **PLAIN).is_success else None
    except (OSError, ValueError, httpx.TransportError):
        return None


def request_of(scene, **fields):
    goal = {"type": "configuration", "name": "ready"}
    search = {"allowed_planning_time": 60.0}
    return {"scene": scene.id, "group": "arm", "goal": goal, "search": search, **fields}


def endless(client):
    """A plan that takes minutes: there is no way through the wall, which no planner knows."""
    scene = client.add_scene(WALLED)
    goal = {"type": "joint", "positions": [0.3, -0.3, 0.0]}
    search = {"allowed_planning_time": 600.0, "attempts": 100, "solve_time": 2.0}
    return request_of(scene, group="body", goal=goal, search=search)


def helpers_of(pid):
    """The processes that make attempts, and the worker of each, which is a child's child."""
    parents = {child: parent for child, parent in living().items() if parent}

    def forebears(child):
        while (child := parents.get(child)) is not None:
            yield child

    below = {child: list(forebears(child)) for child in parents}
    return {child: above[0] for child, above in below.items() if above[2:3] == [pid]}


def living():
    """The parent of every process that is not a zombie."""
    found = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdecimal():
            continue
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if fields[0] != "Z":
            found[int(entry.name)] = int(fields[1])
    return found
