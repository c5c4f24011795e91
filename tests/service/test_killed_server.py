"""A server that is killed at work leaves no process, and one that comes after it loses nothing."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from service.plans.models.plan import Plan
from service.scenes.models.scene import Scene
from tests.service.regions.test_routes import ENDLESS, REQUEST, SCENE
from tests.service.servers import ARM, endless, helpers_of, living, request_of, server, until
from tests.service.successor import successor


@dataclass(frozen=True)
class Left:
    """What a server left when it was killed.

    `scene` and `square` are of an arm and of a body; `done`, `running` and `waiting` are plans;
    `grown` and `growing` are regions; `processes` made a plan's attempts.
    """

    folder: Path
    scene: Scene
    square: str
    done: Plan
    running: Plan
    waiting: list[Plan]
    grown: dict[str, object]
    growing: str
    processes: set[int]


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    folder = tmp_path_factory.mktemp("killed")
    with server(folder, WAYPROOF_SEARCH_PROCESSES="3") as killed:
        client, ask = killed.client, killed.ask
        scene = client.add_scene(ARM)
        done = client.submit_plan(request_of(scene, seed=4))
        list(client.plan_events(done.id))
        square = ask("POST", "/v1/scenes", SCENE)["id"]
        grown = ask("POST", f"/v1/scenes/{square}/regions?wait=60", REQUEST)
        growing = ask("POST", f"/v1/scenes/{square}/regions", ENDLESS)["id"]
        until(lambda: ask("GET", f"/v1/regions/{growing}")["stage"] == "regions")
        running = client.submit_plan(endless(client))
        helpers = until(lambda: helpers_of(killed.process.pid))
        waiting = [client.submit_plan(request_of(scene, seed=i)) for i in range(3)]
        done = client.plan(done.id)
        killed.kill()
    processes = {*helpers, *helpers.values()}
    return Left(folder, scene, square, done, running, waiting, grown, growing, processes)


@pytest.fixture(scope="module")
def restarted(left):
    with successor(left.folder, WAYPROOF_SEARCH_PROCESSES="3") as running:
        yield running


@pytest.fixture(scope="module")
def canceled(left, restarted):
    """What ran when the first server was killed, canceled when it ran again: plan and regions."""
    client, growing = restarted.client, f"/v1/regions/{left.growing}"
    until(lambda: client.plan(left.running.id).state == "running")
    client.cancel_plan(left.running.id)
    until(lambda: restarted.ask("GET", growing)["state"] == "running")
    restarted.ask("POST", f"{growing}/cancel")
    plan = until(lambda: (job := client.plan(left.running.id)).finished_at and job)
    regions = until(lambda: (job := restarted.ask("GET", growing))["finished_at"] and job)
    return plan, regions


def test_its_processes_end_with_it(left):
    until(lambda: not left.processes & set(living()))


def test_what_had_ended_is_as_it_was(left, restarted):
    assert left.done.state == "succeeded"
    assert restarted.client.plan(left.done.id) == left.done
    assert restarted.client.scene(left.scene.id) == left.scene
    assert left.grown["state"] == "succeeded"
    assert restarted.ask("GET", f"/v1/regions/{left.grown['id']}") == left.grown


def test_what_ran_runs_again_and_can_be_canceled(canceled):
    plan, regions = canceled
    assert plan.state == "canceled"
    assert regions["state"] == "canceled"


@pytest.mark.usefixtures("canceled")
def test_what_waited_is_done(left, restarted):
    for job in left.waiting:
        list(restarted.client.plan_events(job.id))
        assert restarted.client.plan(job.id).state == "succeeded"


@pytest.mark.usefixtures("canceled")
def test_the_same_request_gives_the_same_bytes(left, restarted):
    again = restarted.client.submit_plan(request_of(left.scene, seed=4))
    list(restarted.client.plan_events(again.id))
    assert restarted.client.plan(again.id).digest == left.done.digest


@pytest.mark.usefixtures("canceled")
def test_plans_use_the_regions_that_had_grown(left, restarted):
    goal = {"type": "configuration", "name": "beyond"}
    search = {"planner": "GCS", "allowed_planning_time": 60.0}
    request = {"scene": left.square, "group": "body", "goal": goal, "search": search}
    plan = restarted.ask("POST", "/v1/plans?wait=60", request)
    used = plan["result"]["stages"]["search"]["regions"]["digest"]
    assert used == left.grown["summary"]["digest"]
