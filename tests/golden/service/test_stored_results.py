"""What version 0.1 has stored is read, used and carried on by this one.

A copy of its data folder, as it was left by a server that was killed while it planned, is loaded
into a fresh folder; the answers that it gave are recorded beside it.
"""

import json
import re
import sqlite3
from contextlib import closing

import pytest

from tests.golden.service.__main__ import changes
from tests.golden.service.answers import ask, client
from tests.golden.service.calls import get, post
from tests.golden.service.stored import ANSWERS, DONE, DUMP, dump, load, read, settle

STORED = json.loads(ANSWERS.read_text(encoding="utf-8"))
GIVEN = {name: {"id": identifier} for name, identifier in STORED["ids"].items()}


@pytest.fixture
def folder(tmp_path):
    load(DUMP.read_text(encoding="utf-8"), tmp_path / "data")
    return tmp_path / "data"


@pytest.fixture
def service(folder):
    """A server on it, once what was running and queued has been carried on to its end."""
    with client(folder) as running:
        settle(running, GIVEN)
        yield running


def asked(service, call):
    answer = ask(service, call, GIVEN)
    assert answer.status_code < 300, answer.text
    return answer.json()


def executed(service, plan):
    body = {"plan": STORED["ids"][plan], "speed": 50.0}
    return service.post("/v1/executions?wait=60", json=body)


def test_all_that_was_stored_is_answered_as_it_was(service):
    assert changes(STORED["answers"], read(service, GIVEN)) == []


def test_jobs_that_had_not_ended_are_carried_on(service):
    canceled = asked(service, get("", "/v1/plans/{running}"))
    assert canceled["failure"]["code"] == "canceled"
    events = ask(service, get("", "/v1/plans/{running}/events"), GIVEN).text
    assert "the server ended while this ran" in events
    done = asked(service, get("", "/v1/plans/{queued}"))
    assert (canceled["state"], done["state"]) == ("canceled", "succeeded")
    assert done["result"]["certificate"]["proven"]
    kinds = re.findall(
        "event: (.*)", ask(service, get("", "/v1/plans/{queued}/events"), GIVEN).text
    )
    assert (kinds[0], kinds[1], kinds[-1]) == ("queued", "started", "finished")
    assert service.get("/readyz").json()["queued"]["plan"] == 0


def test_old_plans_are_replayed_and_drawn(service):
    for path in ("/v1/plans/{done}/replay.html", "/v1/scenes/{square}/replay.html"):
        page = ask(service, get("", path), GIVEN)
        assert page.status_code == 200, page.text
        assert "const told = " in page.text
    drawing = ask(service, get("", "/v1/plans/{done}/plots/utilisation.svg"), GIVEN)
    assert (drawing.status_code, drawing.headers["content-type"]) == (200, "image/svg+xml")


def test_old_plans_are_executed_from_where_the_robot_was_left(service):
    stale = executed(service, "done")
    assert (stale.status_code, stale.json()["code"]) == (409, "start_mismatch")
    for plan in ("back", "done"):
        answer = executed(service, plan)
        assert answer.status_code == 200, answer.text
        assert answer.json()["state"] == "succeeded"
    assert asked(service, get("", "/v1/scenes/{square}"))["revision"] == 3


def test_an_old_key_gives_the_old_plan_and_an_old_plan_a_new_way_back(service):
    again = asked(service, DONE)
    assert again["id"] == STORED["ids"]["done"]
    back = asked(service, post("", "/v1/plans/{done}/reverse?wait=60"))
    assert (back["state"], back["id"] != STORED["ids"]["back"]) == ("succeeded", True)
    old = asked(service, get("", "/v1/plans/{back}"))
    assert old["result"]["path"] == back["result"]["path"]


def test_old_scenes_and_regions_are_planned_in(service):
    search = {"planner": "GCS", "allowed_planning_time": 60.0}
    scene, goal = STORED["ids"]["square"], {"type": "joint", "positions": [0.2, -0.35, 0.1]}
    request = {"scene": scene, "revision": 2, "group": "body", "goal": goal, "search": search}
    job = service.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job
    assert job["request"]["search"]["regions"] == STORED["ids"]["regions"]
    edit = {"operations": [{"op": "set_positions", "robot": "body", "positions": "home"}]}
    assert service.patch(f"/v1/scenes/{scene}", json=edit).json()["revision"] == 4
    assert service.delete(f"/v1/scenes/{scene}").status_code == 204


def test_the_dump_is_whole_small_and_of_no_machine(folder):
    text = DUMP.read_text(encoding="utf-8")
    assert len(text) < 300_000
    assert not re.search(r"/(tmp|root|home|work)/", text)
    with closing(sqlite3.connect(folder / "wayproof.sqlite")) as database:
        states = database.execute("SELECT lane, state, count(*) FROM jobs GROUP BY lane, state")
        assert {(lane, state): count for lane, state, count in states} == {
            ("execution", "succeeded"): 1,
            ("plan", "canceled"): 1,
            ("plan", "failed"): 1,
            ("plan", "queued"): 1,
            ("plan", "running"): 1,
            ("plan", "succeeded"): 3,
            ("regions", "succeeded"): 1,
        }
        assert database.execute("SELECT count(DISTINCT id), count(*) FROM scenes").fetchone() == (
            2,
            4,
        )
    assert dump(folder) == text
