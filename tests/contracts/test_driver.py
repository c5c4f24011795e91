"""The drivers of this house keep the contract of all drivers."""

from collections.abc import Iterator

import numpy as np
import pytest

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup
from planning.execute.kinematic_driver import KinematicDriver
from planning.execute.simulated_driver import SimulatedDriver
from planning.execute.ur.ur_driver import UrAddress, UrDriver
from planning.world.mechanics.simulation import Simulation
from planning.world.world import World
from tests.conftest import bundled_world
from tests.contracts.driver_contract import DriverContract, DriverRig
from tests.contracts.rtde_stub import RtdeStub


def quintic(world: World, group: JointGroup, delta: list[float]) -> TimedTrajectory:
    """Return a motion of a second from rest to rest, from where the scene puts the group."""
    coefficients = np.zeros((1, 6, group.num_velocities))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[0, power] = factor * np.array(delta)
    start = world.positions(group)[None]
    return TimedTrajectory(group.joints, np.array([0.0, 1.0]), start, coefficients)


CASES = [
    ("ur5e_pickup", "arm", [-0.3, 0.1, -0.2, 0.2, 0.1, 0.3]),
    ("window_3d", "body", [0.3, -0.2, 0.5, 0.1, 0.05, 0.05]),
]


@pytest.fixture(params=CASES, ids=[scene for scene, *_ in CASES])
def case(request: pytest.FixtureRequest) -> tuple[World, JointGroup, TimedTrajectory]:
    scene, name, delta = request.param
    world = bundled_world(scene)
    group = world.group(name)
    return world, group, quintic(world, group, delta)


class TestSimulated(DriverContract):
    @pytest.fixture
    def rig(self, case: tuple[World, JointGroup, TimedTrajectory]) -> DriverRig:
        world, group, motion = case
        driver = SimulatedDriver(Simulation(world, group, motion.start))
        return DriverRig(driver, motion, world.limits(group), driver.stop, 2e-3, 0.05)


class TestKinematic(DriverContract):
    @pytest.fixture
    def rig(self, case: tuple[World, JointGroup, TimedTrajectory]) -> DriverRig:
        world, group, motion = case
        driver = KinematicDriver(motion.manifold, motion.start)
        return DriverRig(driver, motion, world.limits(group), driver.stop, 1e-4, 0.02)


class TestUr(DriverContract):
    @pytest.fixture
    def rig(self) -> Iterator[DriverRig]:
        world = bundled_world("ur5e_pickup")
        group = world.group("arm")
        motion = quintic(world, group, [-0.3, 0.1, -0.2, 0.2, 0.1, 0.3])
        stub = RtdeStub(motion.start.tolist())
        address = UrAddress("127.0.0.1", *stub.ports, timeout=60.0)
        lose = stub.break_connection
        yield DriverRig(UrDriver(address), motion, world.limits(group), lose, 1e-3, 0.05)
        stub.close()
