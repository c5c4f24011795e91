"""/metrics counts jobs, requests, stages, queues, workers and failures, by few labels."""

from datetime import UTC, datetime
from types import SimpleNamespace

import pytest
from prometheus_client.parser import text_string_to_metric_families

from service.api.metrics import Metrics
from service.jobs.dispatch.scheduling.scheduler import QueueLoad


def samples(text):
    """The samples of a text by name and labels."""
    return {
        (sample.name, tuple(sorted(sample.labels.items()))): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def value(text, name, **labels):
    return samples(text).get((name, tuple(sorted(labels.items()))), 0.0)


@pytest.fixture
def scraped(client):
    return lambda: client.get("/metrics").text


def test_requests_are_timed_by_route_and_status(client, scraped):
    found = {"method": "GET", "route": "/v1/plans/{plan}", "status": "404"}
    name = "wayproof_http_request_duration_seconds_count"
    before = value(scraped(), name, **found)
    for i in range(3):
        client.get(f"/v1/plans/pln_{i}")
    after = scraped()
    assert value(after, name, **found) == before + 3
    assert "pln_1" not in after


def test_paths_and_methods_of_no_route_are_one_label(client, scraped):
    for i in range(4):
        client.get(f"/nothing/{i}")
        client.request(f"VERB{i}", "/v1/plans")
        client.get("/v1/plans", headers={"host": f"host{i}"})
    text = scraped()
    for word in ("nothing", "VERB", "host1"):
        assert word not in text
    labels = {"method": "any", "route": "none", "status": "404"}
    assert value(text, "wayproof_http_request_duration_seconds_count", **labels) >= 4


def test_ended_plans_are_timed_by_stage_and_counted_by_failure(client, scene, scraped):
    goal = {"type": "configuration", "name": "ready"}
    request = {"scene": scene, "group": "arm", "goal": goal}
    request["search"] = {"allowed_planning_time": 60.0}
    before = scraped()
    assert client.post("/v1/plans?wait=60", json=request).json()["state"] == "succeeded"
    failed = client.post("/v1/plans?wait=60", json={**request, "start": [0.0] * 6}).json()
    assert failed["state"] == "failed"
    after = scraped()
    searched = ("wayproof_stage_seconds_count", {"queue": "plan", "stage": "search"})
    goals = ("wayproof_stage_seconds_count", {"queue": "plan", "stage": "goals"})
    fault = {"queue": "plan", "code": failed["failure"]["code"]}
    for (name, labels), more in (
        (searched, 1),
        (goals, 2),
        (("wayproof_job_failures_total", fault), 1),
    ):
        assert value(after, name, **labels) == value(before, name, **labels) + more


def test_queues_and_workers_are_shown(scraped):
    text = scraped()
    for queue in ("plan", "query", "execution", "regions"):
        assert value(text, "wayproof_queue_length", queue=queue) == 0
        assert value(text, "wayproof_workers_ready", queue=queue) >= 1
    assert value(text, "wayproof_jobs", queue="plan", state="succeeded") >= 1


def test_waits_and_loaded_scenes_are_counted(client, scene, scraped):
    waits = ("wayproof_queue_wait_seconds_count", {"queue": "query"})
    hits = ("wayproof_world_cache_total", {"queue": "query", "outcome": "hit"})
    misses = ("wayproof_world_cache_total", {"queue": "query", "outcome": "miss"})
    question = {"group": "arm", "configurations": [[0.0] * 6]}
    client.post(f"/v1/scenes/{scene}/check", json=question)  # from here on it is loaded
    before = scraped()
    for _ in range(3):
        assert client.post(f"/v1/scenes/{scene}/check", json=question).is_success
    after = scraped()
    for (name, labels), more in ((waits, 3), (hits, 3), (misses, 0)):
        assert value(after, name, **labels) == value(before, name, **labels) + more


def test_a_scene_that_is_not_loaded_is_a_miss_and_what_is_about_none_is_neither():
    metrics = Metrics()
    for was_warm in (True, False, False, None):
        metrics.note_assignment("plan", 0.5, was_warm=was_warm)
    shown = metrics.exposition({}, {"plan": QueueLoad(num_waiting=4, num_running=2, num_ready=3)})
    assert value(shown, "wayproof_queue_wait_seconds_sum", queue="plan") == 2.0
    assert value(shown, "wayproof_queue_wait_seconds_count", queue="plan") == 4
    counted = [
        value(shown, "wayproof_world_cache_total", queue="plan", outcome=outcome)
        for outcome in ("hit", "miss")
    ]
    assert counted == [1, 2]
    found = [
        value(shown, f"wayproof_{name}", queue="plan")
        for name in ("queue_length", "workers_busy", "workers_ready")
    ]
    assert found == [4, 2, 3]


def ended(queue="plan", **fields):
    blank = {"result": None, "failure": None, "finished_at": datetime.now(UTC)}
    return SimpleNamespace(queue=queue, **{**blank, **fields})


def test_two_apps_count_apart():
    one, other = Metrics(), Metrics()
    one.note_end(ended(failure={"code": "no_path_found", "timings": {"search": 2.0}}))
    nothing = ({}, {})
    shown = one.exposition(*nothing)
    assert value(shown, "wayproof_job_failures_total", queue="plan", code="no_path_found") == 1
    assert value(shown, "wayproof_stage_seconds_sum", queue="plan", stage="search") == 2.0
    assert "no_path_found" not in other.exposition(*nothing)


def test_jobs_that_lack_what_is_counted_do_no_harm():
    metrics = Metrics()
    for result in (None, {}, {"timings": None}, {"timings": {"a": "b", "c": None, "d": 1}}, []):
        metrics.note_end(ended(result=result))
    shown = metrics.exposition({}, {})
    assert value(shown, "wayproof_stage_seconds_count", queue="plan", stage="d") == 1
    assert 'stage="a"' not in shown
