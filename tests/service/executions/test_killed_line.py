"""The line of executions that wait for their robots outlives the server."""

from tests.profiles import only_campaign
from tests.service.executions.crossing import CROSSING, GOALS
from tests.service.servers import server, until
from tests.service.successor import successor

# So slowly that the robot is still where the next motion begins.
CREEP = 0.002


@only_campaign("a server starts twice: 15 s")
def test_a_server_that_is_killed_keeps_the_line_and_its_order(tmp_path):
    with server(tmp_path) as killed:
        scene = killed.ask("POST", "/v1/scenes", CROSSING)["id"]
        there = plan(killed, scene, GOALS["a"])
        back = plan(killed, scene, [-0.4, 0.0, 0.0], start=GOALS["a"])
        moves = execution(killed, there, speed=CREEP)
        until(lambda: killed.ask("GET", f"/v1/executions/{moves}")["status"])
        ids = [execution(killed, each, when_busy="wait") for each in (there, back, there)]
        killed.ask("POST", f"/v1/executions/{ids[2]}/cancel")
        killed.kill()
    with successor(tmp_path) as restarted:

        def shown(identifier):
            return restarted.ask("GET", f"/v1/executions/{identifier}")

        until(lambda: shown(ids[1])["finished_at"])
        assert shown(moves)["failure"]["code"] == "server_restarted"
        states = [shown(each)["state"] for each in ids]
        assert states == ["succeeded", "succeeded", "canceled"]
        assert shown(ids[0])["finished_at"] <= shown(ids[1])["started_at"]


def plan(asked, scene, goal, **fields):
    request = {"scene": scene, "group": "a", "goal": {"type": "joint", "positions": goal}}
    job = asked.ask("POST", "/v1/plans?wait=60", {**request, **fields})
    assert job["state"] == "succeeded", job["failure"]
    return job["id"]


def execution(asked, plan, speed=50, **fields):
    body = {"plan": plan, "driver": "kinematic", "speed": speed, **fields}
    return asked.ask("POST", "/v1/executions", body)["id"]
