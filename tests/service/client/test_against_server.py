"""Both clients against a server: a scene, a plan, what comes of it, and the end of everything."""

import asyncio
import re
from pathlib import Path

import pytest

from tests.profiles import only_campaign
from tests.service.servers import ARM, endless
from wayproof_client import ApiError, AsyncClient, JobFailed

GOAL = {"type": "configuration", "name": "ready"}
SEARCH = {"allowed_planning_time": 60.0}


@pytest.fixture
def client(real_server):
    """The one with the old names too, which `endless` speaks."""
    return real_server.client


def test_from_a_scene_to_an_execution(client):
    assert client.is_ready()
    assert client.get_health().version
    assert "ur5e" in client.list_models().items
    scene = client.create_scene(ARM)
    found = client.solve_inverse_kinematics(
        scene.id,
        {
            "group": "arm",
            "goal": {
                "type": "pose",
                "poses": [{"position": [0.4, 0.2, 0.4], "quaternion": [0, 1, 0, 0]}],
            },
        },
    )
    assert found.configurations
    plan = client.run_plan({"scene": scene.id, "group": "arm", "goal": GOAL, "search": SEARCH})
    assert plan.result.certificate.proven
    assert [event.event for event in client.follow(plan)][-1] == "finished"
    assert client.get_trajectory(plan.id, points=5).times[-1] == plan.result.trajectory.duration
    assert client.get_trajectory_as(plan.id, format="csv").startswith(b"time,")
    assert plan.id in {one.id for one in client.all_plans(scene=scene.id, limit=1)}
    moved = client.run_execution({"plan": plan.id, "speed": 20.0})
    assert moved.state == "succeeded"
    assert {one.event for one in client.follow(moved)} >= {"status", "finished"}
    assert client.get_plot(plan.id, "position").lstrip().startswith("<?xml")
    client.delete_plan(plan.id)
    with pytest.raises(ApiError, match="not_found"):
        client.get_plan(plan.id)


def test_a_canceled_plan_and_a_batch(client):
    job = client.create_plan(endless(client))
    assert client.cancel(job).id == job.id
    with pytest.raises(JobFailed, match="canceled"):
        client.wait(job)
    scene = client.create_scene(ARM)
    problem = {"scene": scene.id, "group": "arm", "goal": GOAL, "search": SEARCH}
    batch = client.wait(client.create_batch({"problems": [problem, problem | {"seed": 2}]}))
    assert batch.counts.succeeded == 2
    assert {event.data.plan for event in client.follow(batch)} == set(batch.plans)


def test_awaited_operations_run_side_by_side(real_server):
    async def both():
        async with AsyncClient(real_server.url) as client:
            scene = await client.create_scene(ARM)
            request = {"scene": scene.id, "group": "arm", "goal": GOAL, "search": SEARCH}
            plans = await asyncio.gather(*(client.run_plan(request | {"seed": i}) for i in (1, 2)))
            kinds = [event.event async for event in client.follow(plans[0])]
            ids = [one.id async for one in client.all_plans(scene=scene.id, limit=1)]
            view = await client.view(plans[0], plots=("position",))
            return plans, kinds, ids, view

    plans, kinds, ids, view = asyncio.run(both())
    assert all(plan.result.certificate.proven for plan in plans)
    assert (kinds[0], kinds[-1]) == ("queued", "finished")
    assert set(ids) == {plan.id for plan in plans}
    assert view.html.count("<img") == 1


@only_campaign("5 s")
def test_the_page_runs(real_server, monkeypatch):
    root = Path(__file__).parents[3]
    monkeypatch.chdir(root)
    page = (root / "docs" / "how-to" / "client.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    program = "\n".join(blocks).replace("http://127.0.0.1:8470", real_server.url)
    shown = {}
    exec(compile(program, "page", "exec"), shown)
    shown["client"].close()
    assert shown["plan"].state == "succeeded"
    assert shown["execution"].state == "succeeded"
    assert len(blocks) == 4
