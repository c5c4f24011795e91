"""Drivers by their names in requests."""

from typing import Literal

from planning import Simulation, World
from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.execute.driver import Driver
from planning.execute.kinematic_driver import KinematicDriver
from planning.execute.simulated_driver import SimulatedDriver


def driver_of(
    name: Literal["simulated", "kinematic"], world: World, group: JointGroup, start: Array
) -> Driver:
    """Return a driver of a group that is at rest at `start`, shape (nq,).

    Raises:
        ModelInvalid: The group cannot be simulated: a joint moves no mass.
    """
    if name == "kinematic":
        return KinematicDriver(Manifold.of(group.joints), start)
    return SimulatedDriver(Simulation(world, group, start))
