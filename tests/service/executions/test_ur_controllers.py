"""Arms of Universal Robots over HTTP, with a stand-in for their controller on loopback."""

import numpy as np
import pytest
from starlette.testclient import TestClient

from planning.domain.curves.interpolation import trajectory_through
from planning.errors import NotCertified
from service.app import create_app
from service.executions.drivers.drivers import sampling_reserve
from service.executions.tasks import ExecutionWork
from service.settings import Settings
from tests.conftest import bundled_world
from tests.contracts.rtde_stub import RtdeStub
from tests.service.executions.test_routes import ARM, executed, finished, planned

CELL = {"type": "ur_rtde", "host": "cell"}


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    """A server that may drive one controller, whose stub each test starts."""
    folder = tmp_path_factory.mktemp("ur")
    hosts: dict[str, str] = {}
    settings = Settings(engine="inline", data_dir=folder, query_timeout=300, ur_hosts=hosts)
    with TestClient(create_app(settings)) as running:
        running.hosts = settings.ur_hosts
        yield running


@pytest.fixture
def scene(client):
    return client.post("/v1/scenes", json=ARM).json()


@pytest.fixture
def stub(client, scene):
    (group,) = [g for g in scene["groups"] if "arm" in (g["name"], *g["aliases"])]
    controller = RtdeStub(group["positions"])
    rtde, script = controller.ports
    client.hosts["cell"] = f"127.0.0.1:{rtde}:{script}"
    yield controller
    controller.close()
    client.hosts.clear()


def test_a_plan_is_carried_out_by_a_controller(client, scene, stub):
    plan = planned(client, scene, "ready")
    execution = executed(client, plan, driver=CELL, speed=1).json()
    assert execution["state"] == "succeeded", execution["failure"]
    assert execution["request"]["driver"] == CELL
    np.testing.assert_allclose(stub.q, plan["result"]["goal_configuration"], atol=1e-6)
    np.testing.assert_allclose(execution["status"]["positions"], stub.q, atol=1e-3)
    assert execution["status"]["torques"] is None
    sampling = execution["sampling"]
    # 5 rad/s^2, every 8 ms, smoothed over 30 ms
    assert sampling["deviation"] == pytest.approx(5.0 * (0.008**2 + 0.03**2) / 8)
    assert 0 < sampling["approach"] < 0.01
    assert sampling["clearance"] is None or sampling["clearance"] > sampling["approach"]


def test_without_enough_clearance_for_sampling_nothing_moves():
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    home = world.positions(group)
    motion = trajectory_through(group.joints, np.array([0.0, 1.0]), np.array([home, home + 0.1]))
    work = ExecutionWork.model_construct(address="192.0.2.7", clearance=None)
    found = sampling_reserve(work, world, group, motion)
    assert found is not None
    assert found.clearance is None
    enough = work.model_copy(update={"clearance": 1.001 * found.approach})
    assert sampling_reserve(enough, world, group, motion) is not None
    little = work.model_copy(update={"clearance": 0.999 * found.approach})
    with pytest.raises(NotCertified) as refusal:
        sampling_reserve(little, world, group, motion)
    assert refusal.value.evidence["check"] == "sampling"
    assert refusal.value.evidence["value"] == found.approach
    simulated = work.model_copy(update={"address": None})
    assert sampling_reserve(simulated, world, group, motion) is None


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"driver": {"type": "ur_rtde", "host": "192.0.2.1"}}, "192.0.2.1"),
        ({"driver": {"type": "ur_rtde"}}, "/driver"),
        ({"driver": CELL, "speed": 2}, "speed"),
    ],
)
def test_a_client_cannot_have_the_server_connect_elsewhere(client, scene, stub, fields, named):
    plan = planned(client, scene, "ready")
    refused = client.post("/v1/executions", json={"plan": plan["id"], **fields})
    assert refused.status_code == 422
    assert named in refused.text
    assert stub.program == ""


def test_a_robot_elsewhere_than_the_scene_says_does_not_move(client, scene, stub):
    plan = planned(client, scene, "ready")
    stub.q[0] += 0.05
    execution = executed(client, plan, driver=CELL, speed=1).json()
    assert execution["state"] == "aborted"
    assert execution["failure"]["code"] == "tracking_lost"
    assert execution["failure"]["evidence"]["bound"] == 0.02
    assert len({tuple(target) for target in stub.targets}) <= 1


def test_a_lost_controller_aborts_and_says_that_the_robot_may_move(client, scene, stub):
    plan = planned(client, scene, "ready")
    request = {"plan": plan["id"], "driver": CELL, "speed": 0.01}
    path = client.post("/v1/executions", json=request).headers["location"]
    assert client.post(f"{path}/speed", json={"speed": 1.5}).status_code == 422
    stub.safety_mode = 3  # a protective stop
    ended = finished(client, path)
    assert ended["state"] == "aborted"
    assert ended["failure"]["code"] == "driver_lost"
    assert ended["failure"]["evidence"]["rests"] is False
