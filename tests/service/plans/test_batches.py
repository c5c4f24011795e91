"""Many plans in one request: all or none, one stream, one cancel, one key."""

import re
import uuid
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.client.events import decode_events
from service.plans.batch_events import id_of, positions_of
from tests.service.servers import WALLED, until

READY = {"type": "configuration", "name": "ready"}


@pytest.fixture
def problem(scene):
    return {
        "scene": scene,
        "group": "arm",
        "goal": READY,
        "search": {"allowed_planning_time": 60.0},
    }


@pytest.fixture
def blocked(client):
    """A problem whose plan goes on until it is canceled."""
    headers = {"Content-Type": "application/yaml"}
    scene = client.post("/v1/scenes", content=WALLED, headers=headers).json()["id"]
    goal = {"type": "joint", "positions": [0.3, -0.3, 0.0]}
    search = {"allowed_planning_time": 600.0, "attempts": 100, "solve_time": 2.0}
    return {"scene": scene, "group": "body", "goal": goal, "search": search}


@pytest.fixture(scope="module")
def ended(client, scene):
    """A batch of three plans, of which the second failed."""
    one = {"scene": scene, "group": "arm", "goal": READY}
    one["search"] = {"allowed_planning_time": 60.0}
    problems = [{**one, "seed": 1}, {**one, "start": [0.0] * 6}, {**one, "seed": 2}]
    answer = client.post("/v1/plans/batch?wait=60", json={"problems": problems})
    assert answer.status_code == 200, answer.text
    return answer.json()


def events_of(client, batch, last=None):
    headers = {} if last is None else {"Last-Event-ID": last}
    with client.stream("GET", f"/v1/batches/{batch}/events", headers=headers) as answer:
        assert answer.status_code == 200
        return list(decode_events(answer))


def test_a_batch_is_plans_in_the_order_of_the_problems(client, ended):
    assert ended["counts"] == {
        "queued": 0,
        "running": 0,
        "succeeded": 2,
        "failed": 1,
        "canceled": 0,
    }
    assert ended["created_at"] < ended["finished_at"]
    plans = [client.get(f"/v1/plans/{plan}").json() for plan in ended["plans"]]
    assert [plan["state"] for plan in plans] == ["succeeded", "failed", "succeeded"]
    assert [plan["seed"] for plan in plans] == [1, 0, 2]
    assert {plan["batch"] for plan in plans} == {ended["id"]}
    assert client.get(f"/v1/batches/{ended['id']}").json() == ended
    listed = client.get(f"/v1/plans?batch={ended['id']}").json()["items"]
    assert [plan["id"] for plan in listed] == ended["plans"][::-1]
    failed = client.get(f"/v1/plans?batch={ended['id']}&state=failed").json()["items"]
    assert [plan["id"] for plan in failed] == ended["plans"][1:2]


def test_a_batch_is_accepted_and_says_where_to_poll(client, problem):
    answer = client.post("/v1/plans/batch", json={"problems": [problem]})
    assert answer.status_code == 202
    assert answer.headers["location"] == f"/v1/batches/{answer.json()['id']}"
    path = answer.headers["location"]
    assert until(lambda: client.get(path).json()["finished_at"])


def test_one_stream_has_the_events_of_all_plans_and_is_replayed_from_any_of_them(client, ended):
    events = events_of(client, ended["id"])
    by_plan = {plan: [] for plan in ended["plans"]}
    for event in events:
        by_plan[event.data["plan"]].append(event)
    for plan, own in by_plan.items():
        with client.stream("GET", f"/v1/plans/{plan}/events") as answer:
            alone = list(decode_events(answer))
        assert [event.type for event in own] == [event.type for event in alone]
        assert [{**event.data, "plan": plan} for event in alone] == [event.data for event in own]
    for i in range(0, len(events), 5):
        rest = events_of(client, ended["id"], events[i].id)
        for plan in ended["plans"]:
            left = [event.data for event in events[i + 1 :] if event.data["plan"] == plan]
            assert [event.data for event in rest if event.data["plan"] == plan] == left
    for wrong in ("7", "x", "e*9", "e.e.e.e"):
        assert len(events_of(client, ended["id"], wrong)) == len(events)


def test_all_are_canceled_at_once(client, problem, blocked):
    batch = client.post("/v1/plans/batch", json={"problems": [blocked] + [problem] * 20}).json()
    path = f"/v1/batches/{batch['id']}"
    until(lambda: client.get(path).json()["counts"]["running"])
    refused = client.delete(path)
    assert (refused.status_code, refused.json()["code"]) == (409, "illegal_transition")
    assert len(client.get(path).json()["plans"]) == 21
    assert client.post(f"{path}/cancel").status_code == 200
    told = until(lambda: (found := client.get(path).json())["finished_at"] and found)
    assert told["counts"]["canceled"] >= 20
    assert client.post(f"{path}/cancel").json() == told
    assert client.delete(path).status_code == 204
    assert client.get(path).status_code == 404
    assert client.get(f"/v1/plans/{batch['plans'][3]}").status_code == 404


def test_a_key_gives_the_same_batch_and_another_body_is_refused(client, problem):
    headers = {"Idempotency-Key": uuid.uuid4().hex}
    body = {"problems": [problem, {**problem, "seed": 4}]}
    first = client.post("/v1/plans/batch?wait=60", json=body, headers=headers).json()
    again = client.post("/v1/plans/batch?wait=60", json=body, headers=headers).json()
    assert again == first
    assert len(client.get(f"/v1/plans?batch={first['id']}").json()["items"]) == 2
    for path, other in (("/v1/plans/batch", {"problems": [problem]}), ("/v1/plans", problem)):
        told = client.post(path, json=other, headers=headers)
        assert (told.status_code, told.json()["code"]) == (409, "idempotency_conflict")


@pytest.mark.parametrize(
    ("change", "status", "code", "pointer"),
    [
        ({"group": "amr"}, 422, "unknown_name", "/problems/2/group"),
        ({"goal": {"type": "configuration", "name": "redy"}}, 422, "unknown_name", "/goal/name"),
        ({"search": {"planner": "RRTConect"}}, 422, "unknown_name", "/search/planner"),
        ({"goal": {"type": "joint", "positions": [1.0]}}, 409, "wrong_joint_count", "/positions"),
        ({"search": {"regions": "reg_0"}}, 422, "problem_invalid", "/search/regions"),
        ({"scene": "scn_0"}, 404, "not_found", "/problems/2"),
        ({"search": {"planner": "GCS"}, "margin": 9.0}, 409, "no_regions", "/problems/2"),
        ({"seed": -1}, 422, "request_invalid", "/problems/2/seed"),
        ({"sead": 1}, 422, "request_invalid", "/problems/2/sead"),
    ],
)
def test_what_is_wrong_with_one_problem_is_told_with_its_place_and_nothing_is_queued(
    client, problem, change, status, code, pointer
):
    before = client.get("/v1/plans?limit=1").json()["items"]
    answer = client.post("/v1/plans/batch", json={"problems": [problem, problem, problem | change]})
    told = answer.json()
    assert (answer.status_code, told["code"]) == (status, code)
    [error] = told["errors"]
    assert error["pointer"].startswith("/problems/2")
    assert error["pointer"].endswith(pointer)
    assert client.get("/v1/plans?limit=1").json()["items"] == before


@pytest.mark.parametrize("count", [0, 257])
def test_a_batch_has_1_to_256_problems(client, problem, count):
    answer = client.post("/v1/plans/batch", json={"problems": [problem] * count})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["pointer"] == "/problems"


@pytest.mark.parametrize("path", ["", "/events", "/cancel"])
@pytest.mark.parametrize("batch", ["bat_0", "pln_0", "%20"])
def test_a_batch_that_there_is_not_is_not_found(client, path, batch):
    ask = client.post if path == "/cancel" else client.get
    assert ask(f"/v1/batches/{batch}{path}").status_code == 404


@given(st.lists(st.one_of(st.none(), st.integers(0, 3), st.integers(0, 10**8)), min_size=1))
def test_an_id_holds_the_place_in_every_stream(positions):
    told = id_of(positions)
    assert positions_of(told, len(positions)) == positions
    assert positions_of(told, len(positions) + 1) == [0] * (len(positions) + 1)
    assert len(told.split(".")) == len(list(groupby(positions)))


def test_the_id_of_many_plans_is_short():
    positions = [None] * 200 + [7, 12] + [1] * 54
    assert id_of(positions) == "e*200.7.12.1*54"


@given(st.text(max_size=30))
def test_what_is_no_id_is_the_beginning(text):
    found = positions_of(text, 3)
    is_one = re.fullmatch(r"(e|[0-9]+)(\*[0-9]+)?(\.(e|[0-9]+)(\*[0-9]+)?)*", text)
    assert len(found) == 3
    assert is_one or found == [0, 0, 0]


def test_an_id_that_claims_millions_is_not_believed():
    assert positions_of(".".join(["e*9999"] * 400), 3) == [0, 0, 0]


def test_batches_are_listed_as_they_are_shown(client, ended):
    shown = client.get(f"/v1/batches/{ended['id']}").json()
    del shown["plans"]
    listed = client.get("/v1/batches?limit=200").json()["items"]
    assert [item for item in listed if item["id"] == ended["id"]] == [shown]


def test_batches_are_listed_newest_first(client, problem):
    body = {"problems": [problem]}
    two = [client.post("/v1/plans/batch?wait=60", json=body).json()["id"] for _ in range(2)]
    names = [item["id"] for item in client.get("/v1/batches?limit=200").json()["items"]]
    assert [name for name in names if name in two] == two[::-1]


def test_batches_are_found_by_what_one_plan_of_theirs_is(client, ended, blocked):
    def found(query):
        return [item["id"] for item in client.get(f"/v1/batches?limit=200&{query}").json()["items"]]

    other = client.post("/v1/plans/batch", json={"problems": [blocked]}).json()
    scene = blocked["scene"]
    try:
        assert ended["id"] in found("state=succeeded")
        assert ended["id"] in found("state=failed")
        assert ended["id"] not in found("state=canceled")
        assert other["id"] not in found("state=failed")
        assert found(f"scene={scene}") == [other["id"]]
        assert found(f"scene={scene}&state=succeeded") == []
        [listed] = client.get(f"/v1/batches?scene={scene}").json()["items"]
        assert listed["finished_at"] is None
    finally:
        client.post(f"/v1/batches/{other['id']}/cancel")
