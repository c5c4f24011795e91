"""A service in this process, and scenes that many tests need."""

import warnings

import pytest

from service.app import create_app
from service.settings import Settings
from tests.service.servers import server

with warnings.catch_warnings():
    # Starlette wants a client that is not among our dependencies yet.
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient

BLOCK_SCENE = {
    "name": "block",
    "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}],
    "objects": [
        {"name": "block", "shape": {"box": [0.1, 0.1, 0.1]}, "pose": {"position": [0.6, 0, 0.05]}},
        # where the hand is when all joints are at zero
        {"name": "post", "shape": {"box": [0.1, 0.1, 0.3]}, "pose": {"position": [0.8, 0.3, 0.15]}},
    ],
    "frames": [{"name": "above", "parent": "block", "pose": {"position": [0, 0, 0.3]}}],
}


def pytest_collection_modifyitems(items):
    """Let the tests that share a server follow one another: most often in one process then."""
    sharing = [item for item in items if "real_server" in getattr(item, "fixturenames", ())]
    if sharing:
        first, moved = items.index(sharing[0]), set(sharing)
        rest = [item for item in items if item not in moved]
        items[:] = [*rest[:first], *sharing, *rest[first:]]


@pytest.fixture(scope="session")
def settings(tmp_path_factory):
    """A folder of its own for each process of the tests, and time for what a busy machine does."""
    folder = tmp_path_factory.mktemp("state")
    return Settings(engine="inline", data_dir=folder, query_timeout=300, best_grace=60)


@pytest.fixture(scope="session")
def app(settings):
    return create_app(settings)


@pytest.fixture(scope="session")
def client(app):
    with TestClient(app) as running:
        yield running


@pytest.fixture(scope="session")
def real_server(tmp_path_factory):
    """A server in a process of its own, on a free port, with a folder of its own."""
    with server(tmp_path_factory.mktemp("real"), WAYPROOF_SEARCH_PROCESSES="3") as running:
        yield running


@pytest.fixture(scope="session")
def document(client):
    return client.get("/openapi.json").json()


@pytest.fixture(scope="session")
def scene(client):
    """The id of a posted scene with an arm, a block and a post."""
    return client.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]


@pytest.fixture(scope="session")
def few_regions(client, scene):
    """Regions that have grown: one."""
    request = {"group": "arm", "num_regions": 1, "num_free": 100, "iterations": 1}
    request |= {"along": "nothing", "allowed_time": 60.0}
    job = client.post(f"/v1/scenes/{scene}/regions?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    assert job["summary"]["num_regions"] == 1
    return job


@pytest.fixture(scope="session")
def solved(client, scene):
    """A plan that succeeded: from home to ready."""
    goal = {"type": "configuration", "name": "ready"}
    request = {"scene": scene, "group": "arm", "goal": goal, "seed": 3}
    request["search"] = {"allowed_planning_time": 60.0}
    answer = client.post("/v1/plans?wait=60", json=request)
    assert answer.status_code == 200, answer.text
    job = answer.json()
    assert job["state"] == "succeeded", job["failure"]
    return job
