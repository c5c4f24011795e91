"""The torque check: its bound holds, is tight, and refuses motions that are too fast."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planning.certify.certifier import CertifyRequest
from planning.certify.torque.torque_check import torque_check
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation import trajectory_through
from planning.domain.report.certificate import Check
from planning.domain.robot.payload import Payload
from planning.errors import DeadlineExceeded, ModelInvalid
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel
from planning.world.world import World
from tests.certify.chains import Robot, random_robot, random_trajectory
from tests.certify.conftest import quintic, request_for
from tests.certify.torque.test_taylor_torques import drake_efforts
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

PENDULUM = """<robot name="p"><link name="base"/><link name="bob"><inertial>
<origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="swing" type="revolute"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="100" effort="20"/><dynamics damping="{damping}"/></joint>
</robot>"""


def torque_check_of(model: DrakeModel, request: CertifyRequest, **budget: float) -> Check:
    return torque_check(model, replace(request, effort=True), no_hurry(), **budget)


def with_efforts(robot: Robot, trajectory: TimedTrajectory, limit: float) -> CertifyRequest:
    request = robot.request(trajectory, PairMargins(0.0, {}, {}))
    efforts = np.full(len(robot.group.blocks), limit)
    return replace(request, limits=replace(request.limits, effort=efforts))


def sampled_peak(robot: Robot, trajectory: TimedTrajectory, count: int = 800) -> float:
    ends = trajectory.breaks[1:-1]
    evenly = np.linspace(0, trajectory.duration, count)
    times = np.concatenate([evenly, ends - 1e-9, ends + 1e-9])
    efforts = drake_efforts(robot, trajectory, times)
    blocks = [list(indices) for _, indices in robot.group.blocks]
    return max(float(np.linalg.norm(efforts[:, block], axis=1).max()) for block in blocks)


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 10_000))
def test_the_bound_is_above_every_sample_and_near_the_largest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, int(rng.integers(1, 5)), 0, mass=1.0)
    trajectory = random_trajectory(rng, robot.group, 2, spread=0.3)
    peak = sampled_peak(robot, trajectory)
    check = torque_check_of(robot.model, with_efforts(robot, trajectory, 2 * peak))
    assert check.passed
    assert check.value + 1e-9 >= 0.5
    assert check.value <= 0.5 * 1.01
    found = drake_efforts(robot, trajectory, np.array([check.time]))
    block = next(list(ix) for name, ix in robot.group.blocks if name == check.where)
    assert np.linalg.norm(found[0, block]) == pytest.approx(peak, rel=0.01)


@settings(max_examples=num_cases(5))
@given(seed=st.integers(0, 10_000))
def test_a_motion_just_within_is_proven_and_one_that_is_too_quick_is_not(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, 3, 0, mass=1.0)
    trajectory = random_trajectory(rng, robot.group, 2, spread=0.4).time_scaled(0.5)
    limit = sampled_peak(robot, trajectory)
    check = torque_check_of(robot.model, with_efforts(robot, trajectory, 1.002 * limit))
    assert check.passed
    assert check.value == pytest.approx(1 / 1.002, rel=2e-3)
    assert not torque_check_of(robot.model, with_efforts(robot, trajectory, limit / 1.0001)).passed
    quick = trajectory.time_scaled(1 / 1.05)
    assume(sampled_peak(robot, quick) > 1.01 * limit)
    assert not torque_check_of(robot.model, with_efforts(robot, quick, 1.002 * limit)).passed


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_the_torque_of_a_pendulum_is_the_analytic_one(
    urdf_world: Callable[..., World], damping: float
) -> None:
    world = urdf_world(PENDULUM.format(damping=damping))
    motion = quintic(world.group("r"), np.array([-0.5]), np.array([1.3]), 0.8)
    times = np.linspace(0, 0.8, 20001)
    q, v, vdot = (
        rows[:, 0]
        for rows in (motion.positions(times), motion.velocities(times), motion.accelerations(times))
    )
    torque = np.abs(0.5 * vdot + 9.81 * np.sin(q) + damping * v)
    check = torque_check_of(world.drake, request_for(world, "r", motion))
    assert check.value == pytest.approx(torque.max() / 20, rel=1.1e-3)
    assert check.value >= torque.max() / 20
    assert check.where == "r::swing"
    assert check.time == pytest.approx(times[torque.argmax()], abs=0.02)


def test_a_payload_counts_as_much_as_the_same_held_object(
    urdf_world: Callable[..., World],
) -> None:
    size, mass = np.array([0.1, 0.2, 0.3]), 3.0
    thing = {
        "name": "thing",
        "shape": {"box": size.tolist()},
        "pose": {"position": [0.1, 0.2, -0.5], "rpy": [0.3, 0.2, 0.1]},
        "mass": mass,
        "attached": {"frame": "r::bob"},
    }
    moments = mass / 12 * (np.sum(size**2) - size**2)
    held = urdf_world(PENDULUM.format(damping=0), objects=[thing])
    payload = Payload.from_parts("thing", mass, (0, 0, 0), (*moments, 0, 0, 0))
    carried = urdf_world(PENDULUM.format(damping=0), objects=[{**thing, "mass": None}])
    motion = quintic(held.group("r"), np.array([-0.5]), np.array([1.3]), 0.8)
    values = [
        torque_check_of(world.drake, replace(request_for(world, "r", motion), payload=load)).value
        for world, load in ((held, None), (carried, payload), (carried, None))
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-9)
    assert values[0] > 1.2 * values[2]


def test_an_exhausted_budget_refuses() -> None:
    world = bundled_world("ur5e_pickup")
    q = world.positions(world.group("arm"))
    request = request_for(world, "arm", quintic(world.group("arm"), q, q + 0.5, 1.0))
    assert torque_check_of(world.drake, request).passed
    refused = torque_check_of(world.drake, request, max_segments=2, max_joint_motion=9.0)
    assert not refused.passed
    assert refused.value > 1


def test_expired_deadlines_and_bodies_without_mass_are_refused() -> None:
    world = bundled_world("ur5e_pickup")
    q = world.positions(world.group("arm"))
    request = request_for(world, "arm", quintic(world.group("arm"), q, q + 0.5, 1.0))
    with pytest.raises(DeadlineExceeded):
        torque_check(world.drake, replace(request, effort=True), no_hurry(-1.0))
    rng = np.random.default_rng(0)
    robot = random_robot(rng, 2, 0)
    weightless = random_trajectory(rng, robot.group, 1, spread=0.1)
    with pytest.raises(ModelInvalid, match="no mass or inertia"):
        torque_check_of(robot.model, with_efforts(robot, weightless, 1.0))


@pytest.mark.parametrize("size", [3e4, 1e60, 1e200])
def test_motions_that_overflow_are_refused(size: float) -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q = world.positions(group)
    wild = quintic(group, q, q + 1e-3, 1.0)
    coefficients = np.array(wild.coefficients)
    coefficients[0, 3:] *= size
    check = torque_check_of(
        world.drake, request_for(world, "arm", replace(wild, coefficients=coefficients))
    )
    assert not check.passed
    assert not check.value <= 1


def test_many_short_pieces_leave_a_budget_for_halving() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q = world.positions(group)
    times = np.linspace(0, 1, 61)
    smooth = quintic(group, q, q + 0.5, 1.0)
    motion = trajectory_through(
        group.joints,
        times,
        smooth.positions(times),
        smooth.velocities(times),
        smooth.accelerations(times),
    )
    whole = torque_check_of(world.drake, request_for(world, "arm", smooth))
    check = torque_check_of(world.drake, request_for(world, "arm", motion), max_segments=20)
    assert check.passed
    assert check.value == pytest.approx(whole.value, rel=2e-3)
