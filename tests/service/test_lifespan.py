"""How workers are shared between what is asked of them."""

import pytest

from service.errors import NotReady
from service.lifespan import _queues
from service.settings import Settings


def test_plans_questions_and_regions_share_a_pool_and_executions_have_their_own(tmp_path):
    settings = Settings(
        engine="process", data_dir=tmp_path, plan_slots=3, query_slots=2, regions_slots=1
    )
    lanes = _queues(settings, None)
    pool = lanes["plan"].pool
    assert lanes["query"].pool is pool is lanes["regions"].pool
    assert len(pool.workers) == 3 + (2 + 1) + 1
    assert [lanes[name].max_running for name in ("plan", "query", "regions")] == [3, 3, 1]
    assert lanes["execution"].pool is not pool
    assert len(lanes["execution"].pool.workers) == settings.execution_slots


def test_executions_go_before_what_is_planned_and_come_to_rest_before_they_are_ended(tmp_path):
    settings = Settings(engine="process", data_dir=tmp_path, niceness=7, worker_memory=2**30)
    lanes = _queues(settings, None)
    planning, moving = (lanes[name].pool.workers[0]._terms for name in ("plan", "execution"))
    assert (planning.niceness, moving.niceness) == (7, 0)
    assert planning.memory == moving.memory == 2**30
    assert (planning.memory_grace, moving.memory_grace) == (0.0, 5.0)
    assert planning.is_offline
    assert moving.is_offline


@pytest.fixture
def pool(app, client):
    return app.state.jobs._dispatcher._scheduler.queue("plan").pool


def test_a_posted_scene_is_loaded_for_its_first_plan(client, pool, scene):
    posted = client.get(f"/v1/scenes/{scene}").json()
    edit = {"operations": [{"op": "remove", "object": "post"}]}
    copy = client.post("/v1/scenes", json=posted["document"]).json()
    edited = client.patch(f"/v1/scenes/{copy['id']}", json=edit).json()
    assert edited["digest"] != copy["digest"]
    for made in (copy, edited):
        assert pool.has_warm_idle(made["digest"])


def test_readiness_says_which_workers_are_not(client, app, pool, monkeypatch):
    jobs = app.state.jobs
    for slot in pool.workers:
        monkeypatch.setattr(slot, "fault", "no module named planning")
    with pytest.raises(NotReady):
        jobs.check_ready()
    answer = client.get("/readyz")
    assert answer.status_code == 503
    assert answer.json()["code"] == "not_ready"
    assert answer.json()["evidence"]["faults"]["plan"] == "no module named planning"
    assert set(answer.json()["evidence"]["faults"]) == {"plan", "query", "regions"}
    assert "Retry-After" in answer.headers
    monkeypatch.undo()
    assert client.get("/readyz").is_success
