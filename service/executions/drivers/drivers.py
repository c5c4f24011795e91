"""Drivers by their names in requests, and what sampling by a controller costs of the proof."""

from planning import Simulation, World
from planning.api.approach_bound import approach_bound
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup
from planning.errors import NotCertified
from planning.execute.driver import Driver
from planning.execute.kinematic_driver import KinematicDriver
from planning.execute.simulated_driver import SimulatedDriver
from planning.execute.ur.servo_deviation import servo_deviation
from planning.execute.ur.servo_program import ServoOptions
from planning.execute.ur.ur_driver import UrAddress, UrDriver
from service.executions.models import SamplingReserve
from service.executions.tasks import ExecutionWork


def driver_of(
    work: ExecutionWork, world: World, group: JointGroup, trajectory: TimedTrajectory
) -> Driver:
    """Return the driver of a group that is at rest at the start of a trajectory.

    Raises:
        ModelInvalid: The group cannot be simulated: a joint moves no mass.
    """
    if work.address is not None:
        return UrDriver(_address(work.address))
    if work.request.driver == "kinematic":
        return KinematicDriver(trajectory.manifold, trajectory.start)
    return SimulatedDriver(Simulation(world, group, trajectory.start))


def sampling_reserve(
    work: ExecutionWork, world: World, group: JointGroup, trajectory: TimedTrajectory
) -> SamplingReserve | None:
    """Return what sampling leaves of the proven clearance; None if nothing is sampled.

    Raises:
        NotCertified: Nothing is left.
    """
    if work.address is None:
        return None
    deviations = servo_deviation(world.limits(group), ServoOptions())
    approach = approach_bound(world, group.name, trajectory, deviations)
    if work.clearance is not None and approach >= work.clearance:
        raise _no_reserve(approach, work.clearance)
    return SamplingReserve(
        deviation=float(deviations.max()), approach=approach, clearance=work.clearance
    )


def _no_reserve(approach: float, clearance: float) -> NotCertified:
    message = (
        f"the controller samples and smooths the motion, so bodies may come {approach:.4g} m "
        f"nearer, where only {clearance:.4g} m are proven; plan with a larger margin"
    )
    check = {"name": "sampling", "value": approach, "bound": clearance, "where": ""}
    evidence = {"check": "sampling", "pair": [], "time": 0.0, "value": approach}
    return NotCertified(message, {**evidence, "bound": clearance, "checks": [check]})


def _address(text: str) -> UrAddress:
    """Return the address of `host` or `host:rtde_port:script_port`."""
    host, *ports = text.rsplit(":", 2)
    return UrAddress(host, *map(int, ports)) if len(ports) == 2 else UrAddress(text)
