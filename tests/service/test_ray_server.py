"""A real server on PostgreSQL, its workers on two machines of a Ray cluster; for `make ray`."""

import hashlib
import json
import signal

import pytest
from sqlalchemy import text

from service.jobs.store.sql.database import open_engine
from tests.service.jobs.postgres import cluster as database_cluster
from tests.service.jobs.remote.machines import KINDS, cluster, end_clusters
from tests.service.servers import ARM, endless, request_of, server, until

pytestmark = pytest.mark.skipif(
    "ray" not in KINDS, reason="make ray installs the extra and says so"
)


@pytest.fixture(scope="module")
def database():
    with database_cluster() as made:
        yield made


@pytest.fixture(scope="module")
def on_ray(tmp_path_factory, database):
    machines = cluster(2)
    folder = tmp_path_factory.mktemp("ray")
    with server(folder, **engine(machines), WAYPROOF_DATABASE_URL=database.url) as running:
        yield running
    end_clusters()


def engine(machines):
    return {
        "WAYPROOF_ENGINE": "ray",
        "WAYPROOF_RAY_ADDRESS": machines.address,
        "WAYPROOF_RAY_HOSTS": "2",
        "WAYPROOF_PLAN_SLOTS": "1",
        "WAYPROOF_QUERY_SLOTS": "1",
        "WAYPROOF_EXECUTION_SLOTS": "1",
    }


def digest_of(running, scene):
    job = running.ask("POST", "/v1/plans?wait=120", request_of(scene, seed=3))
    assert job["state"] == "succeeded", job["failure"]
    return hashlib.sha256(json.dumps(job["result"]["trajectory"]).encode()).hexdigest()


def test_a_plan_is_the_same_wherever_it_was_made(on_ray, real_server):
    digests = {
        digest_of(running, running.client.add_scene(ARM)) for running in (on_ray, real_server)
    }
    assert len(digests) == 1


def test_a_plan_that_hangs_is_canceled_on_its_machine(on_ray):
    job = on_ray.ask("POST", "/v1/plans", endless(on_ray.client))
    until(lambda: on_ray.ask("GET", f"/v1/plans/{job['id']}")["stage"])
    ended = on_ray.ask("POST", f"/v1/plans/{job['id']}/cancel")
    ended = until(
        lambda: (now := on_ray.ask("GET", f"/v1/plans/{job['id']}"))["state"] == "canceled" and now
    )
    assert ended["failure"]["code"] == "canceled"


def test_a_server_that_waits_for_its_plans_ends_in_its_own_time(on_ray, tmp_path):
    """Ray has a handler of its own for the signal, which would abort it after three seconds."""
    with server(tmp_path, **engine(cluster(2)), WAYPROOF_DRAIN_SECONDS="6") as running:
        job = running.ask("POST", "/v1/plans", endless(running.client))
        until(lambda: running.ask("GET", f"/v1/plans/{job['id']}")["stage"])
        running.process.terminate()
        assert running.process.wait(120) in {0, -signal.SIGTERM}


def test_a_plan_outlives_the_machine_that_made_it(on_ray, database):
    job = on_ray.ask("POST", "/v1/plans", endless(on_ray.client))
    path = f"/v1/plans/{job['id']}"
    until(lambda: on_ray.ask("GET", path)["stage"])
    machines = cluster(2)
    for node in machines.nodes:
        machines.lose(node)
        machines.add(2)
        until(lambda: on_ray.ask("GET", path)["state"] == "running")
        if reasons := requeued(database, job):
            break
    assert reasons == [f"the machine {machines.ip}/{node[:8]} was lost"]
    until(lambda: on_ray.ask("GET", path)["stage"])
    on_ray.ask("POST", f"{path}/cancel")
    until(lambda: on_ray.ask("GET", path)["state"] == "canceled")
    assert digest_of(on_ray, on_ray.client.add_scene(ARM))


def requeued(database, job):
    """Why a job was queued again, each time."""
    engine = open_engine(database.url)
    with engine.connect() as connection:
        query = text("SELECT data FROM job_events WHERE type = 'requeued' AND job = :job")
        found = [row.data for row in connection.execute(query, {"job": job["id"]})]
    engine.dispose()
    return [
        json.loads(data)["reason"] if isinstance(data, str) else data["reason"] for data in found
    ]
