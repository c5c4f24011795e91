"""A server that is told to end lets plans end for a while, takes none, and stops robots at once."""

import json
import signal
from contextlib import contextmanager

import httpx
import pytest

from service.jobs.states import JobState
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from tests.profiles import num_cases, only_campaign
from tests.service.servers import ARM, PLAIN, endless, request_of, server, until
from tests.service.test_stopping import Motion, held, workers_of

LONG = "600"


@contextmanager
def records(running):
    """The records of a server that has ended."""
    engine = open_engine(f"sqlite:///{running.database}")
    try:
        yield JobStore(engine, {})
    finally:
        engine.dispose()


def get(running, path):
    return httpx.get(running.url + path, timeout=60, **PLAIN)


def told_to_end(running):
    """Tell it, and wait until it is about to."""
    running.process.send_signal(signal.SIGTERM)
    return until(lambda: (answer := get(running, "/readyz")).status_code == 503 and answer)


@only_campaign("5 s")
def test_what_runs_ends_and_nothing_begins_while_a_server_drains(tmp_path):
    log = (tmp_path / "log").open("wb")
    more = {
        "WAYPROOF_DRAIN_SECONDS": LONG,
        "WAYPROOF_LOG_LEVEL": "info",
        "WAYPROOF_PLAN_SLOTS": "1",
    }
    with log, server(tmp_path, log, **more) as running:
        scene = running.client.add_scene(ARM)
        get(running, "/v1/planners")  # workers are asked once which there are
        with held(workers_of(running)):
            plan = running.client.submit_plan(request_of(scene, seed=4))
            until(lambda: running.client.plan(plan.id).state == "running")
            waits = running.client.submit_plan(request_of(scene, seed=5))
            answer = told_to_end(running)
            assert answer.json()["code"] == "server_stopping"
            headers = {"X-Request-ID": "late"}
            body = request_of(scene, seed=6)
            refused = httpx.post(
                f"{running.url}/v1/plans", json=body, headers=headers, timeout=60, **PLAIN
            )
            assert (refused.status_code, refused.json()["code"]) == (503, "server_stopping")
            assert int(refused.headers["retry-after"]) > 0
            assert running.client.plan(plan.id).state == "running"
            assert get(running, "/healthz").is_success
        assert running.process.wait(120) == -signal.SIGTERM
    with records(running) as store:
        ended, queued = store.get(plan.id), store.get(waits.id)
        assert (ended.state, ended.attempts) == (JobState.SUCCEEDED, 1)
        assert (queued.state, queued.attempts) == (JobState.QUEUED, 0)
        assert len(store.page("plan")) == 2
    check_log(tmp_path / "log")


def check_log(file):
    """One line for each record, but for the sentence that says where the server listens."""
    lines = file.read_text().splitlines()
    greeting, *rest = [line for line in lines if not line.startswith("{")]
    assert greeting.startswith("Wayproof listens on")
    assert rest == []
    told = [json.loads(line) for line in lines if line.startswith("{")]
    late = {line["event"]: line for line in told if line.get("request_id") == "late"}
    assert set(late) == {"request", "audit"}
    for line in late.values():
        assert (line["method"], line["path"], line["status"]) == ("POST", "/v1/plans", 503)
    assert {"uvicorn.error", "uvicorn.access", "service.cli.server"} <= {
        line["logger"] for line in told
    }


@only_campaign("6 s each")
@pytest.mark.campaign
@pytest.mark.parametrize("hurry", [signal.SIGTERM, signal.SIGINT][: num_cases(1, 2)])
def test_a_second_signal_waits_for_no_plan_and_the_plan_is_queued_again(tmp_path, hurry):
    with server(tmp_path, WAYPROOF_DRAIN_SECONDS=LONG) as running:
        plan = running.client.submit_plan(endless(running.client))
        until(lambda: running.client.plan(plan.id).stage == "search")
        told_to_end(running)
        running.process.send_signal(hurry)
        running.process.wait(120)
    with records(running) as store:
        queued = store.get(plan.id)
        assert (queued.state, queued.attempts) == (JobState.QUEUED, 0)


@only_campaign("7 s")
def test_a_robot_waits_for_no_drain(tmp_path):
    with server(tmp_path, WAYPROOF_DRAIN_SECONDS=LONG) as running:
        motion = Motion(running)
        plan = running.client.submit_plan(endless(running.client))
        until(lambda: running.client.plan(plan.id).stage == "search")
        told_to_end(running)
        ended = motion.ended()
        assert ended["state"] == "canceled"
        assert 0 < ended["status"]["progress"] < 1
        assert ended["failure"]["evidence"]["reason"] == "the server stopped"
        assert running.client.plan(plan.id).state == "running"
        running.client.cancel_plan(plan.id)
        running.process.wait(120)
