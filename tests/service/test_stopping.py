"""A server, its robots and its disk: what moves can be stopped whatever goes wrong around it."""

import os
import resource
import signal
import threading
from contextlib import ExitStack, contextmanager

import httpx
import numpy as np
import pytest

from tests.profiles import only_campaign
from tests.service.jobs.databases import locked
from tests.service.servers import ARM, living, request_of, server, until
from tests.service.successor import successor

# The same is shown without HTTP, in a tenth of the time, by tests/service/jobs/test_stopping.py.
ONLY_CAMPAIGN = only_campaign("ten seconds each")
# A motion of minutes.
SLOW = {"speed": 0.02}


@pytest.fixture
def running(real_server):
    return real_server


class Motion:
    """An execution of a plan in a scene of its own, which has begun to move."""

    def __init__(self, running):
        self.server = running
        scene = running.client.add_scene(ARM)
        plan = running.client.submit_plan(request_of(scene, refine={"method": "none"}))
        list(running.client.plan_events(plan.id))
        self.plan = running.ask("GET", f"/v1/plans/{plan.id}")
        body = {"plan": plan.id, **SLOW}
        self.path = f"/v1/executions/{running.ask('POST', '/v1/executions', body)['id']}"
        until(lambda: (self.now["status"] or {}).get("progress", 0) > 0)

    @property
    def now(self):
        return self.server.ask("GET", self.path)

    def post(self, what, **body):
        return self.server.ask("POST", f"{self.path}/{what}", body or None)

    def ended(self):
        return until(lambda: (now := self.now)["finished_at"] and now)

    def is_on_path(self, status):
        """Whether a status has the robot where the plan has it at that time."""
        trajectory = self.plan["result"]["trajectory"]
        rows = np.array(trajectory["positions"]).T
        there = [np.interp(status["time"], trajectory["times"], row) for row in rows]
        return np.allclose(status["positions"], there, atol=0.01)


def workers_of(running):
    """The processes that run tasks: children of the forkserver, which is the server's child."""
    parents = living()
    return [pid for pid in parents if parents.get(parents[pid]) == running.process.pid]


@contextmanager
def held(workers):
    """Stop processes meanwhile."""
    try:
        for pid in workers:
            os.kill(pid, signal.SIGSTOP)
        yield
    finally:
        for pid in set(workers) & set(living()):
            os.kill(pid, signal.SIGCONT)


@contextmanager
def full_disk(running):
    """The server's files may not grow: SQLite's writes fail as they do on a full disk."""
    pid = running.process.pid
    before = resource.prlimit(pid, resource.RLIMIT_FSIZE)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (1, before[1]))
    try:
        yield
    finally:
        resource.prlimit(pid, resource.RLIMIT_FSIZE, before)


def check_steered(motion):
    """Every request is obeyed and answered, and says what is not recorded."""
    for what, body in (("pause", {}), ("speed", {"speed": 0.03}), ("resume", {})):
        assert "controls" in motion.post(what, **body)["unrecorded"]
        state = "paused" if what != "resume" else "executing"
        until(lambda state=state: motion.now["status"]["state"] == state)
    answer = motion.post("cancel")
    assert answer["state"] == "canceling"
    assert "cancel" in answer["unrecorded"]
    at_rest = until(lambda: "end" in (now := motion.now)["unrecorded"] and now)
    assert 0 < at_rest["status"]["progress"] < 1
    assert at_rest["finished_at"] is None
    # Not `executing`, as the database has it still.
    assert at_rest["state"] == at_rest["status"]["state"] == "canceling"
    assert at_rest["cancel_requested_at"] == answer["cancel_requested_at"] is not None
    listed = motion.server.ask("GET", "/v1/executions?limit=1")["items"][0]
    assert listed["state"] == "canceling"
    return at_rest


def check_recorded(motion, at_rest):
    ended = motion.ended()
    assert (ended["state"], ended["unrecorded"]) == ("canceled", [])
    assert ended["failure"]["code"] == "canceled"
    assert ended["status"]["positions"] == at_rest["status"]["positions"]
    assert motion.is_on_path(ended["status"])


def test_a_robot_is_steered_and_stopped_while_the_database_is_locked(running):
    motion = Motion(running)
    with locked(running.database):
        at_rest = check_steered(motion)
    check_recorded(motion, at_rest)


@pytest.mark.campaign
@ONLY_CAMPAIGN
def test_a_robot_is_steered_and_stopped_while_the_disk_is_full(running):
    motion = Motion(running)
    with full_disk(running):
        at_rest = check_steered(motion)
        refused = httpx.post(f"{running.url}/v1/plans", json=motion.plan["request"], timeout=120)
        assert refused.status_code == 503
        assert refused.json()["code"] == "database_unavailable"
        assert int(refused.headers["retry-after"]) > 0
    check_recorded(motion, at_rest)


@pytest.mark.campaign
@ONLY_CAMPAIGN
def test_a_plan_that_ends_while_the_disk_is_full_succeeds(running):
    scene = running.client.add_scene(ARM)
    with ExitStack() as stack:
        with held(workers_of(running)):
            job = running.client.submit_plan(request_of(scene, refine={"method": "none"}))
            until(lambda: running.client.plan(job.id).state == "running")
            stack.enter_context(full_disk(running))
        until(lambda: "end" in running.client.plan(job.id).unrecorded)
        # It is not given up after the few seconds in which a busy database is asked again.
        threading.Event().wait(6.0)
        assert running.client.plan(job.id).state == "running"
    ended = until(lambda: (now := running.client.plan(job.id)).finished_at and now)
    assert (ended.state, ended.failure, ended.unrecorded) == ("succeeded", None, [])


def test_a_worker_that_hangs_ends_its_execution_with_a_reason(running):
    motion = Motion(running)
    with held(workers_of(running)):
        ended = motion.ended()
    assert ended["state"] == "aborted"
    assert ended["failure"]["code"] == "worker_unresponsive"
    assert Motion(running).post("cancel")["state"] in {"canceling", "canceled"}


def test_a_server_that_is_told_to_end_brings_its_robot_to_rest_first(tmp_path):
    with server(tmp_path) as first:
        motion = Motion(first)
        first.process.send_signal(signal.SIGTERM)
        first.process.wait(120)
    with successor(tmp_path) as second:
        ended = second.ask("GET", motion.path)
    assert ended["state"] == "canceled"
    assert ended["failure"]["evidence"]["reason"] == "the server stopped"
    assert ended["failure"]["stage"] == "execute"
    assert ended["timings"]["execute"] > 0
    assert 0 < ended["status"]["progress"] < 1
    assert motion.is_on_path(ended["status"])
