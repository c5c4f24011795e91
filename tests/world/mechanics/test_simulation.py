"""The simulation, against closed forms, and under an execution."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.errors import Contact, ModelInvalid, TrackingLost
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from planning.execute.simulated_driver import SimulatedDriver
from planning.world.mechanics.simulation import Simulation
from planning.world.world import World
from tests.conftest import bundled_world

# A point-like mass of 2 kg on a massless rod of 0.5 m, and one of 3 kg on a vertical slide.
PENDULUM = """<robot name="p"><link name="base"/><link name="bob"><inertial>
<origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="swing" type="revolute"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="9" effort="{effort}"/></joint></robot>"""
SLIDE = """<robot name="s"><link name="base"/><link name="cart"><inertial>
<mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="shadow"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="9" effort="200"/><dynamics damping="30"/></joint>
<joint name="echo" type="prismatic"><parent link="base"/><child link="shadow"/><axis xyz="1 0 0"/>
<mimic joint="lift" multiplier="-0.5" offset="0.1"/>
<limit lower="-3" upper="3" velocity="9" effort="200"/></joint></robot>"""
MASSLESS = SLIDE.replace('<mass value="3"/>', '<mass value="0"/>').replace('"0.1" i', '"0" i')


def quintic(world: World, group_name: str, delta: list[float], duration: float) -> TimedTrajectory:
    """Return a motion from rest to rest that leaves where the scene puts the group."""
    group = world.group(group_name)
    coefficients = np.zeros((1, 6, group.num_velocities))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[0, power] = factor * np.array(delta) / duration**power
    start = world.positions(group)[None]
    return TimedTrajectory(group.joints, np.array([0.0, duration]), start, coefficients)


def execute(
    world: World, group_name: str, trajectory: TimedTrajectory
) -> tuple[Runner, Simulation]:
    """Return an execution that has begun, and what it moves."""
    group = world.group(group_name)
    simulation = Simulation(world, group, trajectory.start)
    runner = Runner(Execution(trajectory, world.limits(group)), SimulatedDriver(simulation))
    runner.start(0.0)
    return runner, simulation


def run(runner: Runner, until: float) -> list[Any]:
    statuses: list[Any] = []
    while not runner.is_done and len(statuses) * 0.02 < until:
        statuses.append(runner.tick(0.02 * (len(statuses) + 1)))
    return statuses


def test_without_effort_a_pendulum_swings_as_a_pendulum_does(
    urdf_world: Callable[..., World],
) -> None:
    world = urdf_world(PENDULUM.format(effort=1e-6))
    start = np.array([0.02])
    simulation = Simulation(world, world.group("r"), start)
    frequency = np.sqrt(9.81 / 0.5)
    for time in np.arange(0.1, 1.5, 0.1):
        simulation.advance_to(float(time))
        assert abs(simulation.q[0] - 0.02 * np.cos(frequency * time)) < 1e-3
    assert world.positions(world.group("r"))[0] == 0.0  # the world itself stands still


def test_with_effort_it_is_held_against_gravity(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(PENDULUM.format(effort=100))
    simulation = Simulation(world, world.group("r"), np.array([1.5]))
    simulation.command(np.array([1.5]), np.zeros(1), np.zeros(1))
    simulation.advance_to(0.5)
    assert abs(simulation.q[0] - 1.5) < 1e-6


def test_an_error_dies_out_as_a_critically_damped_one(urdf_world: Callable[..., World]) -> None:
    world, bandwidth, offset = urdf_world(SLIDE), 20.0, 0.01
    simulation = Simulation(world, world.group("r"), np.zeros(1), bandwidth=bandwidth)
    simulation.command(np.array([offset]), np.zeros(1), np.zeros(1))
    for time in (0.05, 0.1, 0.2, 0.4):
        simulation.advance_to(time)
        x = bandwidth * time
        assert abs((offset - simulation.q[0]) - offset * (1 + x) * np.exp(-x)) < 0.02 * offset


def test_joints_that_follow_do_follow(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(SLIDE)
    runner, simulation = execute(world, "r", quintic(world, "r", [0.4], 1.0))
    run(runner, 3.0)
    assert runner.status.state == "succeeded"
    q = simulation.state
    (coupling,) = world.drake.couplings
    assert q[coupling.leader_position] == pytest.approx(0.4, abs=1e-4)
    assert q[coupling.follower_position] == pytest.approx(-0.5 * 0.4 + 0.1, abs=1e-4)


@pytest.mark.parametrize(
    ("scene", "group", "delta"),
    [
        ("ur5e_pickup", "arm", [-0.6, 0.2, -0.3, 0.3, 0.2, 0.5]),
        ("maze_2d", "body", [0.05, 0.03, 0.4]),
        ("window_3d", "body", [0.5, -0.4, 0.9, 0.1, 0.05, 0.05]),
    ],
)
def test_what_keeps_the_limits_is_tracked(scene: str, group: str, delta: list[float]) -> None:
    world = bundled_world(scene)
    trajectory = quintic(world, group, delta, 1.5)
    start = world.state.copy()
    runner, _ = execute(world, group, trajectory)
    statuses = run(runner, 3.0)
    assert runner.status.state == "succeeded"
    assert max(status.tracking_error for status in statuses) < 1e-3
    assert not any(status.contacts for status in statuses)
    reached = trajectory.manifold.distance(runner.status.measured, trajectory.end)
    assert float(reached) < 1e-3
    np.testing.assert_array_equal(world.state, start)


def test_what_does_not_belong_to_the_group_is_held() -> None:
    world = bundled_world("ur5e_pickup")
    runner, simulation = execute(world, "arm", quintic(world, "arm", [1.0, 0, 0, 0, 0, 0], 1.0))
    run(runner, 2.0)
    q = simulation.state
    others = np.setdiff1d(np.arange(len(q)), world.drake.position_indices(world.group("arm")))
    assert len(others) > 0
    np.testing.assert_allclose(q[others], world.state[others], atol=1e-5)


def test_torques_are_those_of_inverse_dynamics(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(PENDULUM.format(effort=100))
    simulation = Simulation(world, world.group("r"), np.array([1.0]))
    simulation.command(np.array([1.0]), np.zeros(1), np.zeros(1))
    simulation.advance_to(0.3)
    np.testing.assert_allclose(simulation.torques, [2 * 9.81 * 0.5 * np.sin(1.0)], rtol=1e-4)


@pytest.mark.parametrize("friction", [0.0, 4.0])
def test_dry_friction_takes_its_torque_whichever_way_a_joint_moves(
    urdf_world: Callable[..., World], friction: float
) -> None:
    """m g and f, upwards; m g less f, downwards, at a constant velocity."""
    slide = SLIDE.replace('damping="30"', f'damping="0" friction="{friction}"')
    world = urdf_world(slide)
    for velocity in (0.2, -0.2):
        simulation = Simulation(world, world.group("r"), np.zeros(1))
        for i in range(100):
            time = 0.004 * i
            simulation.command(np.array([velocity * time]), np.array([velocity]), np.zeros(1))
            simulation.advance_to(time + 0.004)
        expected = 3 * 9.81 + np.sign(velocity) * friction
        np.testing.assert_allclose(simulation.torques, [expected], rtol=0.01)
        assert simulation.q[0] == pytest.approx(velocity * 0.4, abs=1e-3)


def test_what_the_efforts_cannot_do_is_lost(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(PENDULUM.format(effort=5))  # half a turn in 0.2 s takes 230 N m
    runner, _ = execute(world, "r", quintic(world, "r", [2.5], 0.2))
    run(runner, 3.0)
    assert runner.status.state == "aborted"
    assert isinstance(runner.status.failure, TrackingLost)


def test_a_wall_in_the_way_is_touched_and_named(urdf_world: Callable[..., World]) -> None:
    wall = {"name": "lid", "shape": {"box": [1, 1, 0.1]}, "pose": {"position": [0, 0, 0.35]}}
    world = urdf_world(SLIDE, objects=[wall])
    runner, simulation = execute(world, "r", quintic(world, "r", [0.5], 1.0))
    touching = next(status for status in run(runner, 3.0) if status.contacts)
    assert touching.state in {"aborting", "aborted"}
    failure, contact = runner.status.failure, touching.contacts[0]
    assert isinstance(failure, Contact)
    assert contact.force is not None
    assert contact.force >= failure.evidence["force"] > 0  # the worst of the tick that it is in
    assert runner.status.state == "aborted"
    assert abs(simulation.v[0]) <= 0.01  # it ends at rest, not in mid-motion
    assert failure.evidence["pair"] == ["lid", "r::cart"]
    assert contact.bodies == ("lid", "r::cart")
    assert contact.distance <= -failure.evidence["depth"] < -1e-4
    # the sphere's top meets the underside of the lid at a height of 0.3
    np.testing.assert_allclose(contact.points, [[0, 0, 0.3], [0, 0, 0.3]], atol=0.01)
    assert runner.status.measured[0] == pytest.approx(0.2, abs=0.01)


def test_a_cancel_ends_at_rest_within_the_acceleration_limits() -> None:
    world = bundled_world("ur5e_pickup")
    limits: JointLimits = world.limits(world.group("arm"))
    runner, simulation = execute(
        world, "arm", quintic(world, "arm", [1.0, 0.2, -0.3, 0, 0, 0.5], 1.5)
    )
    run(runner, 0.7)
    assert runner.status.path_velocity == 1.0
    runner.cancel()
    before, peak = simulation.v, np.zeros(6)
    for i in range(200):
        runner.tick(0.7 + 0.004 * (i + 1))
        after = simulation.v
        peak = np.maximum(peak, np.abs(after - before) / 0.004)
        before = after
    assert runner.status.state == "canceled"
    assert 0.2 < runner.status.progress < 0.9
    assert np.all(peak <= limits.acceleration * 1.05)
    assert np.max(np.abs(simulation.v)) <= 0.01
    assert runner.status.tracking_error < 1e-3


def test_what_moves_no_mass_is_refused(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(MASSLESS)
    with pytest.raises(ModelInvalid, match="'r'"):
        Simulation(world, world.group("r"), np.zeros(1))
