"""The service as users run it: a process of its own, streamed from, killed and started again."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from service.client.client import Client
from service.client.refused import Refused

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]

WALLED = b"""
name: walled
robots:
  - {name: body, model: planar_l, positions: [-0.35, -0.3, 0]}
objects:
  - {name: wall, shape: {box: [0.02, 9, 0.2]}, pose: {position: [0, 0, 0]}}
"""
SCENE = b"name: s\nrobots:\n  - {name: arm, model: ur5e, positions: home}\n"


@contextmanager
def server(folder):
    """A running server that keeps its records in `folder`; (process, client)."""
    announce = folder / "announce.json"
    announce.unlink(missing_ok=True)
    command = [sys.executable, "-m", "service", "serve", "--port", "0", "--leashed"]
    command += ["--data-dir", str(folder / "state"), "--announce", str(announce)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        with Client(until(lambda: ready_url(announce))) as client:
            yield process, client
    finally:
        process.stdin.close()
        try:
            process.wait(15)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def until(ask, seconds=30.0):
    """The first answer that is true."""
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
        return url if httpx.get(f"{url}/readyz", trust_env=False).is_success else None
    except (OSError, ValueError, httpx.TransportError):
        return None


def request_of(scene, **fields):
    goal = {"type": "configuration", "name": "ready"}
    search = {"allowed_planning_time": 20.0}
    return {"scene": scene.id, "group": "arm", "goal": goal, "search": search, **fields}


def endless(client):
    """A plan that takes minutes: there is no way through the wall, which no planner knows."""
    scene = client.add_scene(WALLED)
    goal = {"type": "joint", "positions": [0.3, -0.3, 0.0]}
    search = {"allowed_planning_time": 600.0, "attempts": 100, "solve_time": 4.0}
    return request_of(scene, group="body", goal=goal, search=search)


def test_plans_stream_live_and_survive_a_restart(tmp_path):
    with server(tmp_path) as (_, client):
        scene = client.add_scene(SCENE)
        job = client.submit_plan(request_of(scene, seed=4))
        types = [event.type for event in client.plan_events(job.id)]
        assert types[0] == "queued"
        assert types[-1] == "finished"
        done = client.plan(job.id)
        assert done.state == "succeeded"
    with server(tmp_path) as (_, client):
        assert client.plan(job.id) == done
        assert client.scene(scene.id) == scene
        again = client.submit_plan(request_of(scene, seed=4))
        list(client.plan_events(again.id))
        assert client.plan(again.id).digest == done.digest


def test_a_server_that_is_killed_leaves_no_plan_running(tmp_path):
    with server(tmp_path) as (process, client):
        scene = client.add_scene(SCENE)
        running = client.submit_plan(endless(client))
        until(lambda: client.plan(running.id).state == "running")
        waiting = [client.submit_plan(request_of(scene, seed=i)) for i in range(3)]
        process.send_signal(signal.SIGKILL)
        process.wait()
    with server(tmp_path) as (_, client):
        until(lambda: client.plan(running.id).state in {"running", "failed"})
        client.cancel_plan(running.id)
        for job in waiting:
            list(client.plan_events(job.id))
            assert client.plan(job.id).state == "succeeded"
        ended = until(lambda: (job := client.plan(running.id)).finished_at and job)
        assert ended.state in {"canceled", "failed"}


def test_a_worker_that_is_killed_takes_no_other_plan_with_it(tmp_path):
    with server(tmp_path) as (process, client):
        scene = client.add_scene(SCENE)
        running = client.submit_plan(endless(client))
        until(lambda: client.plan(running.id).state == "running")
        os.kill(busiest_worker(process.pid), signal.SIGKILL)
        client.cancel_plan(running.id)
        job = client.submit_plan(request_of(scene))
        list(client.plan_events(job.id))
        assert client.plan(job.id).state == "succeeded"
        until(lambda: client.plan(running.id).finished_at)


def test_the_server_answers_while_it_plans_and_stops_plans_at_once(tmp_path):
    with server(tmp_path) as (_, client):
        running = client.submit_plan(endless(client))
        until(lambda: client.plan(running.id).stage == "search")
        begun = time.monotonic()
        for _ in range(20):
            client.plan(running.id)
        assert time.monotonic() - begun < 2.0
        begun = time.monotonic()
        client.cancel_plan(running.id)
        until(lambda: client.plan(running.id).state == "canceled")
        assert time.monotonic() - begun < 2.0
        with pytest.raises(Refused) as refusal:
            client.add_scene(b"robots: []")
        assert refusal.value.problem.code == "scene_invalid"
        with pytest.raises(Refused) as refusal:
            client.plan("pln_nothing")
        assert refusal.value.problem.status == 404


def test_helpers_of_attempts_may_die_and_never_stay(tmp_path, monkeypatch):
    monkeypatch.setenv("WAYPROOF_SEARCH_PROCESSES", "3")
    with server(tmp_path) as (process, client):
        running = client.submit_plan(endless(client))
        helpers = until(lambda: helpers_of(process.pid))
        assert len(helpers) <= 3
        os.kill(min(helpers), signal.SIGKILL)
        until(lambda: min(helpers) not in helpers_of(process.pid))
        assert client.plan(running.id).state == "running"
        begun = time.monotonic()
        client.cancel_plan(running.id)
        until(lambda: client.plan(running.id).state == "canceled")
        assert time.monotonic() - begun < 2.0
        until(lambda: not helpers_of(process.pid))
        client.submit_plan(endless(client))
        helpers = until(lambda: helpers_of(process.pid))
        process.send_signal(signal.SIGKILL)
        process.wait()
        until(lambda: not helpers & set(living()))


def helpers_of(pid):
    """The processes that make attempts: below the server, its forkserver and a worker."""
    parents = {child: parent for child, (parent, _) in living().items()}

    def forebears(child):
        while (child := parents.get(child)) is not None:
            yield child

    return {child for child in parents if list(forebears(child))[2:3] == [pid]}


def busiest_worker(pid):
    """The descendant of a server that has used the most processor time: the one that plans."""
    found = living()
    below, grown = {pid}, True
    while grown:
        more = {child for child, (parent, _) in found.items() if parent in below} - below
        below, grown = below | more, bool(more)
    return max(below - {pid}, key=lambda child: found[child][1])


def living():
    """Parent and processor time of every process that is not a zombie."""
    found = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdecimal():
            continue
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if fields[0] != "Z":
            found[int(entry.name)] = (int(fields[1]), int(fields[11]))
    return found
