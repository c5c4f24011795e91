"""Two servers on one PostgreSQL database, over HTTP: whichever is asked, the answer is the same."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

import pytest

from service.app import create_app
from service.client.events import decode_events
from service.settings import Settings
from tests.profiles import PROFILE, only_campaign
from tests.service.conftest import TestClient
from tests.service.jobs.postgres import cluster
from tests.service.servers import ARM, endless, request_of, server, until


@pytest.fixture(scope="module")
def database():
    with cluster() as made:
        yield made.url


@pytest.fixture(scope="module")
def servers(database, tmp_path_factory):
    """The leader and a follower, each with a data folder of its own."""
    with ExitStack() as stack:
        yield [
            stack.enter_context(TestClient(create_app(settings_of(database, tmp_path_factory))))
            for _ in range(2)
        ]


def settings_of(database, tmp_path_factory):
    folder = tmp_path_factory.mktemp("state")
    return Settings(engine="inline", data_dir=folder, query_timeout=300, database_url=database)


@pytest.fixture
def scene(servers):
    return servers[0].post("/v1/scenes", content=ARM, headers=YAML).json()


YAML = {"Content-Type": "application/yaml"}


def plan_of(scene, goal="ready"):
    goal = {"type": "configuration", "name": goal}
    search = {"allowed_planning_time": 60.0}
    return {"scene": scene["id"], "group": "arm", "goal": goal, "search": search}


def planned(client, scene, **fields):
    job = client.post("/v1/plans?wait=60", json=plan_of(scene) | fields).json()
    assert job["state"] == "succeeded", job
    return job


def positions(client, path):
    group = client.get(path).json()["groups"][0]
    return dict(zip(group["position_names"], group["positions"], strict=True))


def test_each_says_what_it_is(servers):
    roles = [client.get("/readyz").json()["role"] for client in servers]
    assert roles == ["leader", "follower"]
    shown = [client.get("/metrics").text for client in servers]
    assert ["wayproof_is_leader 1.0" in text for text in shown] == [True, False]
    assert ["wayproof_is_leader 0.0" in text for text in shown] == [False, True]


def test_a_plan_is_waited_for_streamed_and_read_at_the_other_server(servers, scene):
    leader, follower = servers
    job = planned(follower, scene)
    assert leader.get(f"/v1/plans/{job['id']}").json() == job
    streams = [client.get(f"/v1/plans/{job['id']}/events").text for client in servers]
    assert streams[0] == streams[1]
    assert "event: finished" in streams[1]


def test_an_edit_at_one_server_is_seen_at_the_other_at_once(servers, scene):
    path = f"/v1/scenes/{scene['id']}"
    for i in range(6):
        editor, reader = servers[:: (-1) ** i]
        known = reader.get(path)
        operation = {"op": "set_positions", "robot": "arm", "positions": {"wrist_1_joint": 0.1 * i}}
        edited = editor.patch(path, json={"operations": [operation]})
        assert edited.status_code == 200, edited.text
        seen = reader.get(path, headers={"If-None-Match": known.headers["ETag"]})
        assert seen.status_code == 200
        assert seen.headers["ETag"] == edited.headers["ETag"] != known.headers["ETag"]
        assert positions(reader, path)["arm::wrist_1_joint"] == pytest.approx(0.1 * i)
        stale = reader.patch(
            path, json={"operations": [operation]}, headers={"If-Match": known.headers["ETag"]}
        )
        assert stale.status_code == 412


def test_edits_at_both_servers_at_once_are_all_carried_out(servers, scene):
    path = f"/v1/scenes/{scene['id']}"

    def add(i):
        pose, shape = {"position": [2.0, 0.2 * i, 0.0]}, {"box": [0.1, 0.1, 0.1]}
        added = {"op": "add", "object": {"name": f"box{i}", "shape": shape, "pose": pose}}
        return servers[i % 2].patch(path, json={"operations": [added]})

    with ThreadPoolExecutor(4) as threads:
        answers = list(threads.map(add, range(8)))
    assert {answer.status_code for answer in answers} == {200}, [each.text for each in answers]
    assert sorted(answer.json()["revision"] for answer in answers) == list(range(2, 10))
    bodies = {name for client in servers for name in client.get(path).json()["bodies"]}
    assert {f"box{i}" for i in range(8)} <= {name.partition("::")[0] for name in bodies}


def test_a_scene_that_is_deleted_while_it_is_edited_is_gone(servers):
    """No revision of it is left, whichever server was quicker."""

    def delete(path):
        return servers[0].delete(path).status_code

    def edit(path):
        operation = {"op": "set_positions", "robot": "arm", "positions": {"wrist_1_joint": 0.2}}
        return servers[1].patch(path, json={"operations": [operation]}).status_code

    with ThreadPoolExecutor(2) as threads:
        for _ in range(5):
            scene = servers[0].post("/v1/scenes", content=ARM, headers=YAML).json()
            path = f"/v1/scenes/{scene['id']}"
            edited, deleted = threads.submit(edit, path), threads.submit(delete, path)
            assert deleted.result() == 204
            assert edited.result() in {200, 404}
            assert [client.get(path).status_code for client in servers] == [404, 404]


def test_an_execution_is_steered_and_shown_at_the_other_server(servers, scene):
    leader, follower = servers
    job = planned(leader, scene)
    body = {"plan": job["id"], "speed": 0.05}
    path = follower.post("/v1/executions", json=body).headers["Location"]
    until(lambda: follower.get(path).json()["status"])
    busy = leader.post("/v1/executions", json=body)
    assert (busy.status_code, busy.json()["code"]) == (409, "robot_busy")
    assert follower.post(f"{path}/pause").status_code == 200
    until(lambda: leader.get(path).json()["state"] == "paused")
    until(lambda: follower.get(path).json()["state"] == "paused")
    assert follower.post(f"{path}/resume").status_code == 200
    until(lambda: follower.get(path).json()["state"] == "executing")
    assert follower.post(f"{path}/cancel").json()["state"] == "canceling"
    until(lambda: follower.get(path).json()["state"] == "canceled")
    rest = follower.get(path).json()["status"]["positions"]
    for client in servers:
        assert list(positions(client, f"/v1/scenes/{scene['id']}").values()) == rest
    late = follower.post(f"{path}/pause")
    assert (late.status_code, late.json()["code"]) == (409, "illegal_transition")


def test_the_live_state_is_told_by_the_other_server_as_it_changes(servers, scene):
    """A follower hears of edits and of motions by notifications."""
    leader, follower = servers
    job = planned(leader, scene)
    stream = f"/v1/scenes/{scene['id']}/state/events?rate=100"
    with (
        ThreadPoolExecutor(1) as threads,
        follower.websocket_connect(f"/v1/scenes/{scene['id']}/state/ws?rate=100") as socket,
    ):
        first = socket.receive_json()
        place = {"op": "add", "object": {"name": "ball", "shape": {"sphere": 0.1}}}
        place["object"]["pose"] = {"position": [5, 5, 5]}
        leader.patch(f"/v1/scenes/{scene['id']}", json={"operations": [place]})
        assert socket.receive_json()["data"]["revision"] == first["data"]["revision"] + 1
        body = {"plan": job["id"], "speed": 0.05}
        told = threads.submit(decoded, follower, f"{stream}&most=4", first["id"])
        path = leader.post("/v1/executions", json=body).headers["Location"]
        events = told.result()
        leader.post(f"{path}/cancel")
        until(lambda: follower.get(path).json()["state"] == "canceled")
        while (event := socket.receive_json())["data"]["robots"][0]["execution"] is not None:
            pass  # it comes to rest
    assert {event.data["robots"][0]["status"] for event in events} <= {"at_rest", "moving"}
    rest = event["data"]["robots"][0]
    assert rest["source"] == {"type": "execution", "id": path.rsplit("/", 1)[1]}
    for client in servers:
        assert client.get(f"/v1/scenes/{scene['id']}/state").json()["robots"] == [rest]


def decoded(client, path, after):
    with client.stream("GET", path, headers={"Last-Event-ID": after}) as answer:
        return list(decode_events(answer))


def test_a_key_at_both_servers_is_one_plan(servers, scene):
    headers = {"Idempotency-Key": "one"}

    def ask(client):
        return client.post("/v1/plans?wait=60", json=plan_of(scene), headers=headers).json()

    with ThreadPoolExecutor(2) as threads:
        answers = list(threads.map(ask, servers))
    assert answers[0]["id"] == answers[1]["id"]
    assert {answer["state"] for answer in answers} == {"succeeded"}


@only_campaign("37 s: plans run twice; `jobs/test_several_servers.py` has a quick one")
@pytest.mark.campaign
def test_when_the_leader_is_killed_the_other_runs_what_it_ran(database, tmp_path):
    """And what it could not begin; both are processes, as users start them."""
    name = database.replace("/postgres?", "/template1?")  # another database of the same cluster
    chosen = {"WAYPROOF_DATABASE_URL": name, "WAYPROOF_QUERY_SLOTS": "1"}
    folders = [tmp_path / name for name in ("first", "second")]
    for folder in folders:
        folder.mkdir()
    with server(folders[0], **chosen) as first, server(folders[1], **chosen) as second:
        roles = [each.ask("GET", "/readyz")["role"] for each in (first, second)]
        assert roles == ["leader", "follower"]
        long = second.client.submit_plan(endless(second.client))
        until(lambda: second.client.plan(long.id).state == "running")
        scene = second.client.add_scene(ARM)
        short = second.client.submit_plan(request_of(scene))
        first.kill()
        until(lambda: second.ask("GET", "/readyz")["role"] == "leader")
        until(lambda: second.client.plan(short.id).state == "succeeded")
        if PROFILE.is_campaign:  # only once the first one, had it lost its network, must rest
            until(lambda: any(kind == "requeued" for kind in kinds(second, long)))
        second.client.cancel_plan(long.id)
        assert list(kinds(second, long)).count("finished") == 1
        assert second.client.plan(long.id).state == "canceled"


def kinds(running, plan):
    """The types of the events of a plan, as they come."""
    return (event.type for event in running.client.plan_events(plan.id))
