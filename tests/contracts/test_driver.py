"""The drivers of this house keep the contract of all drivers."""

import numpy as np
import pytest

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup
from planning.execute.kinematic_driver import KinematicDriver
from planning.execute.simulated_driver import SimulatedDriver
from planning.world.mechanics.simulation import Simulation
from planning.world.world import World
from tests.conftest import bundled_world
from tests.contracts.driver_contract import DriverContract, DriverRig


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
