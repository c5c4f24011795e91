"""A plan that does not mind its deadline is ended soon after it, however long its scene took."""

import threading
import time

import pytest

import service.tasks.plan
from service.app import create_app
from service.plans.admission import SLACK
from service.settings import Settings
from tests.service.conftest import BLOCK_SCENE, TestClient


@pytest.fixture
def own_client(tmp_path):
    """A service for one test: the thread of a plan that hangs is of no more use."""
    with TestClient(create_app(Settings(engine="inline", data_dir=tmp_path))) as running:
        yield running


def test_a_plan_that_does_not_mind_its_deadline_is_ended(own_client, monkeypatch):
    release = threading.Event()

    def hang(*_, **__):
        release.wait(60)

    monkeypatch.setattr(service.tasks.plan, "plan", hang)
    monkeypatch.setattr(service.tasks.plan, "_PATIENCE", 0.5)
    scene = own_client.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]
    request = {"scene": scene, "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    request["search"] = {"allowed_planning_time": 0.5}
    began = time.monotonic()
    try:
        job = own_client.post("/v1/plans?wait=30", json=request).json()
        assert time.monotonic() - began < SLACK / 2
    finally:
        release.set()
    assert job["state"] == "failed"
    assert job["failure"]["code"] == "deadline_exceeded"
    assert job["failure"]["evidence"]["allowed"] == 1.0
